//! What environments of Python's need to be said.

use std::path::{Path, PathBuf};

use copq::{Error, Result};
use copq_envs_python::{Options, PythonEnv, is_task};
use copq_experiments::{OnResume, Plan};

/// The engine of these environments, as a plan names it.
pub const ENGINE: &str = "python";

/// How an environment of Python's is made.
#[derive(clap::Args)]
#[command(next_help_heading = "Environments of Python's (--task PACKAGE:ID)")]
pub struct PythonWorld {
    #[command(flatten)]
    interpreter: Interpreter,

    /// Names of its rewards between commas, in the environment's order. [default: reward, or
    /// reward.0,reward.1,...]
    ///
    /// Their priority is this order, unless --order says another.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    objectives: Vec<String>,

    /// Arguments that it is made with, as JSON: '{"max_episode_steps": 500}'.
    #[arg(long, value_name = "JSON", value_parser = json)]
    env_kwargs: Option<String>,

    /// A module to import first, which registers environments of your own: its name, or its file
    /// PATH.py; may be given several times.
    #[arg(long, value_name = "MODULE")]
    import: Vec<String>,

    /// Longest silence before its start, a reset or a step counts as failed. [default: 60]
    #[arg(long, value_name = "SECONDS")]
    env_timeout: Option<f64>,
}

/// Which Python.
#[derive(clap::Args, Default)]
pub struct Interpreter {
    /// The interpreter that has the environment's package, such as .venv/bin/python. [default: what
    /// COPQ_PYTHON names, or python3]
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
}

impl Interpreter {
    pub fn path(&self) -> Option<&Path> {
        self.python.as_deref()
    }

    /// The plan with this interpreter, if there is one.
    pub fn over(&self, plan: &mut Plan) {
        plan.python = self.python.clone().or(plan.python.take());
    }
}

impl PythonWorld {
    /// The plan with these over it; of a task of Python's also what follows from that.
    pub fn over(&self, plan: &mut Plan) -> anyhow::Result<()> {
        self.interpreter.over(plan);
        for (key, value) in [("objectives", &self.objectives), ("imports", &self.import)] {
            if !value.is_empty() {
                plan.world.insert(key.to_owned(), value.clone().into());
            }
        }
        if let Some(kwargs) = &self.env_kwargs {
            plan.world.insert("kwargs".to_owned(), kwargs.clone().into());
        }
        if let Some(seconds) = self.env_timeout {
            plan.world.insert("timeout".to_owned(), seconds.into());
        }
        if is_task(&plan.task) {
            ENGINE.clone_into(&mut plan.engine);
            plan.run.on_resume = OnResume::NewEpisode;
            return Ok(());
        }
        let is_plain = plan.world.is_empty() && plan.python.is_none();
        let task = &plan.task;
        anyhow::ensure!(
            is_plain,
            "--python, --objectives, --env-kwargs, --import, --env-timeout: wanted a task of \
             Python's, such as --task gymnasium:Pendulum-v1, got {task}"
        );
        Ok(())
    }
}

/// A plan's environment of Python's.
pub fn make_python(plan: &Plan, render: bool) -> Result<PythonEnv> {
    let options: Options = plan
        .world
        .clone()
        .try_into()
        .map_err(|e| Error::other(format!("what {} is made with", plan.task), e))?;
    let python = plan.python.clone();
    let limits = plan.limits.clone();
    PythonEnv::new(&plan.task, &Options { python, limits, render, ..options })
}

fn json(text: &str) -> Result<String, String> {
    match serde_json::from_str::<serde_json::Map<String, serde_json::Value>>(text) {
        Ok(_) => Ok(text.to_owned()),
        Err(error) => Err(format!("wanted an object as JSON ({error})")),
    }
}
