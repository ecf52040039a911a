//! `copq train`: a method, a task, and a folder for everything that the run leaves.

use std::path::PathBuf;

use anyhow::{bail, ensure};
use copq::{Config, Ensemble, EnvSpec, Method, projection};
use copq_candle::Candle;
use copq_experiments::{Plan, Run, RunFolder, RunSettings, with_changes};

use crate::options::{count, positive, whole};
use crate::world::make_env;

/// Trains a method on a robot.
///
/// Leaves a folder with settings, metrics.csv, TensorBoard events, curves and a checkpoint. Ctrl-C
/// saves and exits; copq resume goes on, bit for bit.
#[derive(clap::Args)]
pub struct Train {
    /// What to learn by; copq methods describes each.
    #[arg(
        default_value = "cop-td3",
        value_parser = clap::builder::PossibleValuesParser::new(Method::names())
    )]
    method: String,

    /// Robot and task: what moves, and which rewards it gets, by priority; copq tasks lists them.
    /// [default: a/hopper; b/hopper under a limit, gym/hopper for td3]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,

    /// Short for --task a/NAME, or of the benchmark that the method is for: a robot with rewards
    /// (a), with a cost under a limit (b), with Gymnasium's own reward (gym).
    #[arg(long, value_name = "NAME", conflicts_with = "task")]
    robot: Option<String>,

    /// Another priority order of the objectives, most important first: first letters (vsc), or
    /// names between commas.
    ///
    /// Weights and limits follow. Only bounds that know priorities care.
    #[arg(long, value_name = "ORDER")]
    order: Option<String>,

    /// Physics engine: rapier (pure Rust, nothing to install), mujoco or system (your libmujoco).
    ///
    /// Engines differ a little in contacts and integration; compare runs of one engine only.
    #[arg(long, value_name = "NAME", default_value = "rapier")]
    engine: String,

    /// Whose robots: gym-v5 (Gymnasium's) or paper (Brax's, as in the paper). [default: gym-v5;
    /// paper for cop-td3-paper]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,

    /// How critics that disagree become one cautious value vector; the critics come with it.
    /// [default: the method's own]
    ///
    /// cholesky puts the uncertainty of high-priority objectives first; swap it to see what that is
    /// worth.
    #[arg(long, value_name = "NAME", visible_alias = "projection")]
    bound: Option<String>,

    /// Environment steps to train for; copq resume lets you raise them. [default: 100000; 1000000
    /// for cop-td3-paper]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Seed of every random number. The same seed on the same machine gives the same run, bit for
    /// bit.
    ///
    /// Compare methods over several seeds, each a process of its own.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = whole,
        allow_negative_numbers = true
    )]
    seed: u64,

    /// New folder for everything the run leaves behind. [default: runs/METHOD-TASK-BOUND-sSEED]
    ///
    /// The default also names order, engine, preset and settings where they are not the usual ones.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Environment steps between two evaluations without exploration.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 5_000,
        value_parser = positive,
        allow_negative_numbers = true
    )]
    eval_every: u64,

    /// Episodes of an evaluation, on the same seeds every time; more make a smoother curve.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        value_parser = count,
        allow_negative_numbers = true
    )]
    eval_episodes: usize,

    /// Environment steps between two checkpoints: what a crash can cost you.
    ///
    /// A checkpoint holds the replay buffer, so it grows to hundreds of megabytes, and writing or
    /// loading one needs as much memory again. Ctrl-C writes one too.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 20_000,
        value_parser = positive,
        allow_negative_numbers = true
    )]
    checkpoint_every: u64,

    /// Environment steps that one row of metrics.csv averages over.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1_000,
        value_parser = positive,
        allow_negative_numbers = true
    )]
    log_every: u64,

    /// Threads inside this run; copq resume lets you change them.
    ///
    /// They change no bit of the result. Seeds run best as processes of one thread each.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = count,
        allow_negative_numbers = true
    )]
    threads: usize,

    /// Another value for one of the settings that config.toml lists, such as batch=512; may be
    /// given several times.
    ///
    /// Deeper ones have dots, lists brackets: "networks.hidden=[64, 64]", networks.activation=tanh,
    /// smoothing.std=0.1. none takes away what a run can do without, such as smoothing=none. With
    /// cop-td3-oac, optimism.projection=extremum explores towards another upper bound than
    /// --bound's.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Train {
    pub fn run(self) -> anyhow::Result<()> {
        let method = self.method()?;
        let plan = self.plan(&method);
        let folder =
            self.out.clone().unwrap_or_else(|| PathBuf::from("runs").join(self.folder_name(&plan)));
        train(method, plan, |plan, config| Ok(RunFolder::create(folder, plan, config)?))
    }

    /// The method of that name with the options over it.
    fn method(&self) -> anyhow::Result<Method> {
        let mut method = Method::by_name(&self.method)?;
        if let Some(bound) = &self.bound {
            let name = &method.name;
            let own = method.bound.name();
            ensure!(
                method.critics == Ensemble::Spanning || bound == own,
                "--bound {bound}: wanted none, for {name} has its own, {own}"
            );
            method = method.bound(projection::by_name(bound)?);
        }
        let before = method.config;
        method.config = with_changes(&before, &self.set)?;
        self.check_name(&before, &method.config)?;
        Ok(method)
    }

    /// An error for settings that make another method of it than its name says.
    fn check_name(&self, before: &Config, after: &Config) -> anyhow::Result<()> {
        let has_oac = Method::names().any(|name| name == format!("{}-oac", self.method));
        if (has_oac || self.method.ends_with("-oac"))
            && before.optimism.is_some() != after.optimism.is_some()
        {
            let other = match self.method.strip_suffix("-oac") {
                Some(plain) => format!("{plain}, which explores by noise alone"),
                None => format!("{}-oac, which explores towards the upper bound", self.method),
            };
            bail!("--set optimism: {} would be another method; choose {other}", self.method);
        }
        for (key, before, after) in [
            ("constraint", before.constraint.is_some(), after.constraint.is_some()),
            ("subset", before.subset.is_some(), after.subset.is_some()),
        ] {
            let other = if after { "one that has it" } else { "one without" };
            ensure!(
                before == after,
                "--set {key}: {} would be another method; choose {other} (copq methods)",
                self.method
            );
        }
        Ok(())
    }

    /// The usual name, with the settings that are not the method's own.
    fn folder_name(&self, plan: &Plan) -> String {
        let usual = plan.folder_name();
        let seed = format!("-s{}", plan.run.seed);
        let stem = usual.strip_suffix(&seed).unwrap_or(&usual);
        let tidy = |setting: &String| {
            setting.replace(|c: char| !c.is_ascii_alphanumeric() && !"._".contains(c), "-")
        };
        let changes: Vec<String> =
            self.set.iter().map(|setting| format!("-{}", tidy(setting))).collect();
        format!("{stem}{}{seed}", changes.concat())
    }

    fn plan(&self, method: &Method) -> Plan {
        let paper = method.name == "cop-td3-paper";
        let benchmark = match &method.config.constraint {
            Some(_) => "b",
            None if method.name == "td3" => "gym",
            None => "a",
        };
        let robot = self.robot.as_deref().unwrap_or("hopper");
        let run = RunSettings {
            steps: self.steps.unwrap_or(if paper { 1_000_000 } else { 100_000 }),
            seed: self.seed,
            eval_every: self.eval_every,
            eval_episodes: self.eval_episodes,
            log_every: self.log_every,
            checkpoint_every: self.checkpoint_every,
        };
        let usual = Plan::new(method);
        Plan {
            task: self.task.clone().unwrap_or_else(|| format!("{benchmark}/{robot}")),
            order: self.order.clone(),
            engine: self.engine.clone(),
            preset: self.preset.clone().unwrap_or(if paper {
                "paper".to_owned()
            } else {
                usual.preset
            }),
            threads: self.threads,
            run,
            ..usual
        }
    }
}

/// Trains to the end of a plan, in the folder that `open` makes or reopens when all else has proved
/// to fit.
pub fn train(
    method: Method,
    plan: Plan,
    open: impl FnOnce(&Plan, &Config) -> anyhow::Result<RunFolder>,
) -> anyhow::Result<()> {
    // The world, twice: to learn in, and to be evaluated in.
    let env = make_env(&plan)?;
    check_task(&method, env.spec())?;
    let config = method.config.clone();
    let learner =
        copq::Learner::new(method, env.spec(), &Candle::threads(plan.threads), plan.run.seed)?;
    let trainer = copq::Trainer::new(env, Box::new(learner) as Box<dyn copq::Agent>)?;
    let folder = open(&plan, &config)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}

/// An error for a method that a task does not suit; a note where it suits but something goes
/// unheeded.
fn check_task(method: &Method, spec: &EnvSpec) -> anyhow::Result<()> {
    if method.name == "td3" && spec.objectives.len() > 1 {
        bail!(
            "td3: wanted a task with one objective, such as --task gym/hopper, got {}",
            spec.name
        );
    }
    for objective in spec.objectives.iter().filter(|objective| objective.limit.is_some()) {
        if method.config.constraint.is_none() {
            let cost = &objective.name;
            let weight = objective.weight;
            eprintln!(
                "note: nothing holds the {cost}'s limit here, its weight is {weight}; cop-cal \
                 holds it"
            );
        }
    }
    Ok(())
}
