//! `copq train`: a method, a task, and a folder for everything that the run writes.

use std::path::PathBuf;

use anyhow::{bail, ensure};
use copq::{Ensemble, Method, projection};
use copq_envs_python::is_task;
use copq_experiments::{Plan, RunSettings, letters_of};

use crate::keeping::Keeping;
use crate::options::{count, number_of, positive, whole};
use crate::python::{PythonWorld, limits_given};
use crate::recipe::{Recipe, is_on_policy};
use crate::saved;
use crate::training::{leave, train};

/// Trains a method on a robot.
///
/// Writes a folder with settings, metrics.csv, TensorBoard events, curves and a checkpoint. Ctrl-C
/// saves and exits with code 75; copq resume continues the run, bit for bit.
#[derive(clap::Args)]
pub struct Train {
    /// Method to train; copq methods describes each. [default: cop-td3]
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(Recipe::names()))]
    method: Option<String>,

    /// Begin like the run in this folder; requires --out.
    ///
    /// Copies that run's method, and its task, settings and cadence unless others are given here.
    /// The seed is also copied, unless --seed is given.
    #[arg(long, value_name = "DIR", conflicts_with = "method", requires = "out")]
    like: Option<PathBuf>,

    /// Begin with the best policy of a run's folder, or with a policy file (.safetensors or .onnx).
    ///
    /// Loads the policy's weights and normaliser, but no critics, optimiser or replay. The policy
    /// acts from the first step, with its noise (with --set warm_up=uniform, actions are random at
    /// first). The new folder keeps a copy of it.
    #[arg(long, value_name = "DIR")]
    init_from: Option<PathBuf>,

    /// Robot and task: what moves, and which rewards it gets, by priority; copq tasks lists them.
    /// Or a Python environment as PACKAGE:ID, such as mo-gymnasium:mo-hopper-v5. [default:
    /// a/hopper; b/hopper for methods that hold a cost under a limit]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,

    /// Robot in the benchmark that the method, or the run of --like, is for: short for --task
    /// a/NAME (rewards), b/NAME (a cost under a limit) or gym/NAME (Gymnasium's own reward).
    #[arg(long, value_name = "NAME", conflicts_with = "task")]
    robot: Option<String>,

    /// Priority order of the objectives in place of the task's own, most important first: first
    /// letters (vsc), or names separated by commas.
    ///
    /// Weights and limits stay with their objectives. Only bounds that use priorities are affected.
    #[arg(long, value_name = "ORDER")]
    order: Option<String>,

    /// Number of environments to step together; on-policy methods only. --threads spreads them over
    /// the processors; the results are the same, bit for bit. [default: 1]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    envs: Option<usize>,

    /// Limit of a cost in place of the task's own, such as cost=25: the most that an episode may
    /// cost. May be given several times.
    ///
    /// In a Python environment, any objective with a limit is a cost; its values must be 0 or more.
    #[arg(long, value_name = "COST=LIMIT", value_parser = number_of)]
    limit: Vec<(String, f64)>,

    /// Weights of the objectives in place of the task's own: by name (control=0.5), or all of them
    /// in the task's order (1,1,0.5).
    #[arg(long, value_name = "WEIGHTS", allow_hyphen_values = true)]
    weights: Option<String>,

    /// Physics engine: rapier (pure Rust, nothing to install), mujoco or system (your libmujoco).
    /// [default: rapier]
    ///
    /// Engines differ a little in contacts and integration; compare only runs on the same engine.
    #[arg(long, value_name = "NAME")]
    engine: Option<String>,

    /// Which version of the robots: gym-v5 (Gymnasium's) or paper (Brax's, which the paper uses).
    /// [default: gym-v5; paper for cop-td3-paper]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,

    /// How critics that disagree become one cautious value vector; it also determines the critics.
    /// [default: the method's own]
    ///
    /// cholesky puts the uncertainty of high-priority objectives first; swap it to see what that is
    /// worth.
    #[arg(
        long,
        value_name = "NAME",
        visible_alias = "projection",
        value_parser = clap::builder::PossibleValuesParser::new(projection::names())
    )]
    bound: Option<String>,

    /// Environment steps to train for; copq resume can raise the number. [default: 110000; 1000000
    /// for cop-td3-paper; 1024000 for on-policy methods, whose step size decays over them]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Seed of every random number. The same seed on the same machine gives the same run, bit for
    /// bit. [default: 0]
    ///
    /// Compare methods over several seeds, each in its own process.
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    seed: Option<u64>,

    /// New folder for everything the run writes. [default: runs/METHOD-TASK-BOUND-sSEED]
    ///
    /// The default also names order, engine, preset and settings that differ from the usual ones.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Environment steps between evaluations, which do not explore; 0 for none. [default: 5000;
    /// 20480 for on-policy methods]
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    eval_every: Option<u64>,

    /// Episodes per evaluation, on the same seeds every time; more give a smoother curve. [default:
    /// 10]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    eval_episodes: Option<usize>,

    /// Environment steps between checkpoints: what a crash can cost you. [default: 20000; 102400
    /// for on-policy methods]
    ///
    /// A checkpoint holds the replay buffer, so it grows to hundreds of megabytes. Writing or
    /// loading one needs as much memory again. Ctrl-C also writes one.
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    checkpoint_every: Option<u64>,

    /// Environment steps that one row of metrics.csv averages over. [default: 1000; 2048 for
    /// on-policy methods]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    log_every: Option<u64>,

    #[command(flatten)]
    keeping: Keeping,

    /// Change one of the method's settings, such as batch=512. May be given several times.
    ///
    /// config.toml lists the settings. The error for a wrong name lists all names on its level,
    /// including those not in use, such as networks.precision=backward (products of the backward
    /// pass in bf16) and famo.lr.
    ///
    /// Use dots for nested settings and brackets for lists: "networks.hidden=[64, 64]",
    /// networks.activation=tanh, smoothing.std=0.1. A table changes only what it names:
    /// smoothing={std=0.1}. none removes an optional setting: smoothing=none. With cop-td3-oac,
    /// optimism.projection=extremum explores towards that upper bound instead of --bound's.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,

    #[command(flatten)]
    python: PythonWorld,
}

/// The longest folder name that systems accept.
const LONGEST_NAME: usize = 255;

/// What to train, and the usual name of its folder.
pub struct Prepared {
    pub recipe: Recipe,
    pub plan: Plan,
    pub name: String,
}

impl Train {
    pub fn run(self) -> anyhow::Result<()> {
        let Prepared { recipe, mut plan, name } = self.prepare()?;
        let folder = self.out.unwrap_or_else(|| PathBuf::from("runs").join(name));
        // A run like another one begins with that run's own copy of a policy.
        let copy =
            self.like.filter(|_| self.init_from.is_none()).map(|like| like.join(saved::INIT));
        let init = match copy.filter(|copy| copy.is_file()) {
            Some(copy) => Some(copy),
            None => plan.init_from.as_deref().map(saved::policy_file).transpose()?,
        };
        plan.init_checksum = init.as_deref().map(saved::checksum).transpose()?;
        let open = |recipe: &Recipe, plan: &Plan| Ok(recipe.create(&folder, plan)?);
        leave(&train(recipe, plan, init, None, open)?)
    }

    /// What these options amount to, before anything is created.
    pub fn prepare(&self) -> anyhow::Result<Prepared> {
        let (base, recipe) = self.base()?;
        let usual_steps = base.run.steps;
        let plan = self.plan(base)?;
        let recipe = self.recipe(recipe.stretched(usual_steps, plan.run.steps))?;
        let plan = match &recipe {
            Recipe::OffPolicy(Method { bound, critics, .. }) => {
                Plan { bound: Some(bound.name().to_owned()), critics: Some(*critics), ..plan }
            }
            Recipe::OnPolicy(_) => plan,
        };
        let name = match self.folder_name(&plan) {
            long if long.len() > LONGEST_NAME => short_name(&long),
            name => name,
        };
        Ok(Prepared { name, recipe, plan })
    }

    /// What the options apply to: the plan and method of another run, or a method's usual ones.
    fn base(&self) -> anyhow::Result<(Plan, Recipe)> {
        if let Some(folder) = &self.like {
            return Ok(saved::run(folder)?);
        }
        let recipe = Recipe::by_name(self.method.as_deref().unwrap_or("cop-td3"))?;
        Ok((recipe.usual_plan(), recipe))
    }

    /// The method with the options applied.
    fn recipe(&self, recipe: Recipe) -> anyhow::Result<Recipe> {
        let recipe = match (recipe, &self.bound) {
            (Recipe::OffPolicy(method), Some(bound)) => {
                Recipe::OffPolicy(with_bound(method, bound)?)
            }
            (Recipe::OnPolicy(method), Some(bound)) => {
                bail!("--bound {bound}: wanted none, because {} has no bound", method.name)
            }
            (recipe, None) => recipe,
        };
        let recipe = if self.init_from.is_some() { recipe.by_its_policy() } else { recipe };
        recipe.with_changes(&self.set)
    }

    /// The plan with the options applied.
    fn plan(&self, base: Plan) -> anyhow::Result<Plan> {
        let run = RunSettings {
            steps: self.steps.unwrap_or(base.run.steps),
            seed: self.seed.unwrap_or(base.run.seed),
            eval_every: self.eval_every.unwrap_or(base.run.eval_every),
            eval_episodes: self.eval_episodes.unwrap_or(base.run.eval_episodes),
            log_every: self.log_every.unwrap_or(base.run.log_every),
            checkpoint_every: self.checkpoint_every.unwrap_or(base.run.checkpoint_every),
            ..base.run
        };
        let benchmark = base.task.split('/').next().unwrap_or_default();
        let of_robot = self.robot.as_ref().map(|robot| format!("{benchmark}/{robot}"));
        for (i, (cost, limit)) in self.limit.iter().enumerate() {
            let is_first = self.limit[..i].iter().all(|(known, _)| known != cost);
            ensure!(is_first, "--limit {cost}={limit}: wanted one limit of a cost, got two");
        }
        let task = self.task.clone().or(of_robot).unwrap_or_else(|| base.task.clone());
        let is_elsewhere = task != base.task || self.python.renames();
        let inherited = if is_elsewhere { limits_given(&base)? } else { base.limits.clone() };
        let mut plan = Plan {
            task,
            order: self.order.clone().or(base.order),
            limits: inherited.into_iter().chain(self.limit.iter().cloned()).collect(),
            weights: self.weights.clone().or(base.weights),
            engine: self.engine.clone().unwrap_or(base.engine),
            preset: self.preset.clone().unwrap_or(base.preset),
            envs: self.envs.unwrap_or(base.envs),
            init_from: self.init_from.clone().or(base.init_from),
            run,
            ..base
        };
        self.keeping.over(&mut plan);
        self.python.over(&mut plan)?;
        let (name, envs) = (&plan.method, plan.envs);
        ensure!(
            envs == 1 || is_on_policy(name),
            "--envs: wanted 1 for {name}, which learns from one environment (on-policy methods, \
             such as ppo, take several), got {envs}"
        );
        let is_free = self.engine.is_none() && self.preset.is_none();
        let task = &plan.task;
        ensure!(
            is_free || !is_task(task),
            "--engine, --preset: wanted none, because {task} brings its own environment"
        );
        Ok(plan)
    }

    /// The usual name, with the settings that are not the method's own.
    fn folder_name(&self, plan: &Plan) -> String {
        let usual = plan.folder_name();
        let seed = format!("-s{}", plan.run.seed);
        let stem = usual.strip_suffix(&seed).unwrap_or(&usual);
        let tidy = |setting: &String| {
            setting.replace(|c: char| !c.is_ascii_alphanumeric() && !"._".contains(c), "-")
        };
        let settings = self.set.iter().map(tidy);
        let arguments = self.python.arguments().map(|text| tidy(text).trim_matches('-').to_owned());
        let changes: Vec<String> =
            arguments.into_iter().chain(settings).map(|change| format!("-{change}")).collect();
        format!("{stem}{}{seed}", changes.concat())
    }
}

/// A short folder name where the settings are too many: letters that stand for them.
pub fn short_name(long: &str) -> String {
    let (stem, seed) = long.rsplit_once("-s").unwrap_or((long, "0"));
    let start: String = stem.chars().take(100).collect();
    format!("{start}-{}-s{seed}", letters_of(stem))
}

/// The method with another bound; an error for a method that has its own.
fn with_bound(method: Method, bound: &str) -> anyhow::Result<Method> {
    let usual = Method::by_name(&method.name)?;
    let name = &usual.name;
    let own = usual.bound.name();
    let is_part_of_it =
        usual.config.subset.is_some() || matches!(usual.critics, Ensemble::Separate { .. });
    ensure!(
        !is_part_of_it || bound == own,
        "--bound {bound}: wanted none, for {name} has its own, {own}"
    );
    // The same bound must not remove a part of the method, such as REDQ's subset.
    if bound == method.bound.name() {
        Ok(method)
    } else {
        Ok(method.bound(projection::by_name(bound)?))
    }
}
