//! Options of Python environments.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use copq::{Error, Result};
use copq_envs_python::{Options, PACKAGES, PythonEnv, is_task};
use copq_experiments::{OnResume, Plan};

/// The engine of these environments, as a plan names it.
pub const ENGINE: &str = "python";

/// How a Python environment is made.
#[derive(clap::Args)]
#[command(next_help_heading = "Python environments (--task PACKAGE:ID)")]
pub struct PythonWorld {
    #[command(flatten)]
    process: PythonProcess,

    /// Names of its rewards, separated by commas, in the environment's order. [default: reward, or
    /// reward.0,reward.1,...; for Safety-Gymnasium, cost,reward]
    ///
    /// Safety-Gymnasium's cost comes first, whatever it is called. This order is also their
    /// priority, unless --order is given. Your own environment has several rewards if its
    /// reward_space says how many: Box(-inf, inf, (2,)).
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    objectives: Vec<String>,

    /// Arguments to make it with, as JSON: '{"max_episode_steps": 500}'.
    #[arg(long, value_name = "JSON", value_parser = json)]
    env_kwargs: Option<String>,

    /// Module to import first, which registers your own environments: its name, or its file
    /// PATH.py. May be given several times.
    ///
    /// Runs do not notice when it changes: give the runs of each version their own folder.
    #[arg(long, value_name = "MODULE")]
    import: Vec<String>,
}

/// The process that a Python environment lives in; it changes no number of a run.
#[derive(clap::Args, Default)]
#[command(next_help_heading = "Python environments (--task PACKAGE:ID)")]
pub struct PythonProcess {
    /// Interpreter that has the environment's package, such as .venv/bin/python. [default: what
    /// COPQ_PYTHON names, or python3; for an existing run, its own]
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,

    /// Longest silence before a reset or a step counts as failed; starting may take five times as
    /// long. [default: 60]
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    env_timeout: Option<f64>,
}

impl PythonProcess {
    /// The plan with these applied; an error if its task does not use them.
    pub fn over(&self, plan: &mut Plan) -> anyhow::Result<()> {
        let is_used = self.python.is_some() || self.env_timeout.is_some();
        anyhow::ensure!(!is_used || is_task(&plan.task), of_python(&plan.task));
        plan.python = self.python.clone().or(plan.python.take());
        plan.env_timeout = self.env_timeout.or(plan.env_timeout);
        Ok(())
    }
}

impl PythonWorld {
    /// The plan with these applied, and what follows from its task.
    pub fn over(&self, plan: &mut Plan) -> anyhow::Result<()> {
        if !is_task(&plan.task) {
            let is_plain =
                self.objectives.is_empty() && self.env_kwargs.is_none() && self.import.is_empty();
            anyhow::ensure!(is_plain, of_python(&plan.task));
            forget_python(plan);
            return self.process.over(plan);
        }
        ENGINE.clone_into(&mut plan.engine);
        plan.run.on_resume = OnResume::NewEpisode;
        self.process.over(plan)?;
        // Whoever resumes the run may have a different one.
        plan.python =
            plan.python.take().or_else(|| std::env::var_os("COPQ_PYTHON").map(Into::into));
        if !self.objectives.is_empty() {
            let names: Vec<_> = self.objectives.iter().map(|name| name.trim()).collect();
            plan.world.insert("objectives".to_owned(), names.into());
        }
        if !self.import.is_empty() {
            plan.world.insert("imports".to_owned(), self.import.clone().into());
        }
        if let Some(kwargs) = &self.env_kwargs {
            plan.world.insert("kwargs".to_owned(), kwargs.clone().into());
        }
        // Written down, so that it can be read in the run's folder.
        plan.limits = options(plan)?.with_usual_limit(&plan.task).limits;
        Ok(())
    }

    /// Whether its rewards get other names.
    pub fn renames(&self) -> bool {
        !self.objectives.is_empty()
    }

    /// What distinguishes its folder from others of the same environment.
    pub fn arguments(&self) -> Option<&String> {
        self.env_kwargs.as_ref()
    }
}

/// A plan's limits, except for the one that its task has by default: another task has its own.
pub fn limits_given(plan: &Plan) -> Result<BTreeMap<String, f64>> {
    if !is_task(&plan.task) {
        return Ok(plan.limits.clone());
    }
    let none = Options { limits: BTreeMap::new(), ..options(plan)? };
    let usual = none.with_usual_limit(&plan.task).limits;
    let mut limits = plan.limits.clone();
    limits.retain(|cost, limit| usual.get(cost) != Some(limit));
    Ok(limits)
}

/// Drops what a plan copied from a run in a Python environment does not need elsewhere.
fn forget_python(plan: &mut Plan) {
    if plan.engine == ENGINE {
        let usual = Plan::on_policy("any");
        plan.engine = usual.engine;
        plan.run.on_resume = OnResume::SameEpisode;
        plan.world.clear();
        (plan.python, plan.env_timeout, plan.versions) = (None, None, None);
    }
}

fn of_python(task: &str) -> String {
    format!(
        "--python, --objectives, --env-kwargs, --import, --env-timeout: wanted a Python environment \
         (--task PACKAGE:ID, of {}), got {task}",
        PACKAGES.join(", ")
    )
}

/// A plan's Python environment. Relative paths are looked for in the current folder, and in the
/// run's folder and those above it if there is one.
pub fn make_python(plan: &Plan, run: Option<&Path>, render: bool) -> Result<PythonEnv> {
    let options = options(plan)?;
    let python = plan.python.as_ref().map(|python| found(python, run));
    let import = |import: &String| match import.ends_with(".py") {
        true => found(Path::new(import), run).to_string_lossy().into_owned(),
        false => import.clone(),
    };
    let options = Options {
        python,
        imports: options.imports.iter().map(import).collect(),
        render,
        ..options
    };
    PythonEnv::new(&plan.task, &options)
}

/// What a plan says about such an environment.
fn options(plan: &Plan) -> Result<Options> {
    let told: Options = plan
        .world
        .clone()
        .try_into()
        .map_err(|e| Error::other(format!("what {} is made with", plan.task), e))?;
    let timeout = plan.env_timeout.unwrap_or(told.timeout);
    Ok(Options { limits: plan.limits.clone(), timeout, ..told })
}

/// Where a relative path of a run leads.
fn found(path: &Path, run: Option<&Path>) -> PathBuf {
    let is_name = path.components().count() == 1 && path.extension().is_none();
    if path.exists() || path.is_absolute() || is_name {
        return path.to_owned();
    }
    let run = run.and_then(|run| std::path::absolute(run).ok()).unwrap_or_default();
    let found = run.ancestors().map(|folder| folder.join(path)).find(|path| path.exists());
    found.unwrap_or_else(|| path.to_owned())
}

/// A JSON object, written in one canonical way.
fn json(text: &str) -> Result<String, String> {
    match serde_json::from_str::<serde_json::Map<String, serde_json::Value>>(text) {
        Ok(object) => Ok(serde_json::Value::Object(object).to_string()),
        Err(error) => Err(format!("wanted a JSON object ({error})")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A benchmark's limit stays with its task; one that was given goes along.
    #[test]
    fn limits_that_were_given() {
        let mut plan = Plan::new(&copq::Method::cop_cal());
        let mut given = |task: &str, limits: &[(&str, f64)]| {
            task.clone_into(&mut plan.task);
            let limits = limits.iter().map(|(name, limit)| ((*name).to_owned(), *limit));
            plan.limits = limits.collect();
            limits_given(&plan).unwrap().into_iter().collect::<Vec<_>>()
        };
        let goal = "safety-gymnasium:SafetyPointGoal1-v0";
        assert_eq!(given(goal, &[("cost", 25.0)]), []);
        assert_eq!(given(goal, &[("cost", 10.0)]), [("cost".to_owned(), 10.0)]);
        assert_eq!(given("b/hopper", &[("cost", 25.0)]), [("cost".to_owned(), 25.0)]);
    }
}
