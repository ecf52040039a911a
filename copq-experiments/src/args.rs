//! The command-line options that every training program has.

use std::path::PathBuf;

use copq::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::config;
use crate::folder::{RunFolder, read_config, read_plan};
use crate::plan::Plan;

/// Options of a training program; add them to its own with `#[command(flatten)]`.
///
/// An option that is not given comes from the program's [`Plan`], or with `--resume` from the run's folder.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Args {
    /// Robot and task: what moves, and which rewards it gets, by priority. [default: a/hopper, or b/hopper under a limit]
    #[arg(long, value_name = "NAME")]
    pub task: Option<String>,

    /// Short for --task a/NAME: a robot with benchmark A's rewards (safety, velocity, control).
    #[arg(long, value_name = "NAME", conflicts_with = "task")]
    pub robot: Option<String>,

    /// Another priority order of the objectives, most important first: first letters (vsc), or names between commas.
    ///
    /// Weights and limits follow. Only projections that know priorities care.
    #[arg(long, value_name = "ORDER")]
    pub order: Option<String>,

    /// Physics engine: rapier (pure Rust, nothing to install), mujoco or system (your libmujoco). [default: rapier]
    ///
    /// Engines differ a little in contacts and integration; compare runs of one engine only.
    #[arg(long, value_name = "NAME")]
    pub engine: Option<String>,

    /// Whose robots: gym-v5 (Gymnasium's) or paper (Brax's, as in the paper). [default: gym-v5, or the method's own]
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,

    /// How critics that disagree become one cautious value vector. [default: cholesky, or the method's own]
    ///
    /// cholesky puts the uncertainty of high-priority objectives first; swap it to see what that is worth.
    #[arg(long, value_name = "NAME")]
    pub projection: Option<String>,

    /// Environment steps to train for; --resume lets you raise them. [default: 100000, or the method's own]
    #[arg(long, value_name = "N")]
    pub steps: Option<u64>,

    /// Seed of every random number. The same seed on the same machine gives the same run, bit for bit. [default: 0]
    ///
    /// Compare methods over several seeds, each a process of its own.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,

    /// New folder for everything the run leaves behind. [default: runs/METHOD-TASK-PROJECTION-sSEED]
    ///
    /// The default also names order, engine and preset where they are not the usual ones.
    #[arg(long, value_name = "DIR", conflicts_with = "resume")]
    pub out: Option<PathBuf>,

    /// Go on with the run in this folder from its last checkpoint, as if it had never stopped.
    #[arg(long, value_name = "DIR")]
    pub resume: Option<PathBuf>,

    /// Environment steps between two evaluations without exploration. [default: 5000]
    #[arg(long, value_name = "N")]
    pub eval_every: Option<u64>,

    /// Episodes of an evaluation, on the same seeds every time; more make a smoother curve. [default: 10]
    #[arg(long, value_name = "N")]
    pub eval_episodes: Option<usize>,

    /// Environment steps between two checkpoints: what a crash can cost you. [default: 20000]
    ///
    /// A checkpoint holds the replay buffer, so it grows to hundreds of megabytes, and writing or loading one needs as
    /// much memory again. Ctrl-C writes one too.
    #[arg(long, value_name = "N")]
    pub checkpoint_every: Option<u64>,

    /// Environment steps that one row of metrics.csv averages over. [default: 1000]
    #[arg(long, value_name = "N")]
    pub log_every: Option<u64>,

    /// Threads inside this run; --resume lets you change them. [default: 1]
    ///
    /// They change no bit of the result. Seeds run best as processes of one thread each.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,

    /// Another value for one of the settings that config.toml lists, such as batch=512; may be given several times.
    ///
    /// Deeper ones have dots, lists brackets: "networks.hidden=[64, 64]", networks.activation=tanh, smoothing.std=0.1.
    /// none takes away what a run can do without, such as smoothing=none.
    #[arg(long, value_name = "KEY=VALUE", conflicts_with = "resume")]
    pub set: Vec<String>,
}

impl Args {
    /// The options given on the command line over `defaults`; with `--resume`, over the saved plan, which they may
    /// not contradict.
    pub fn plan(&self, defaults: Plan) -> Result<Plan> {
        let plan = match &self.resume {
            None => self.over(defaults),
            Some(folder) => {
                let saved = read_plan(folder)?;
                check_program(&defaults.program, &saved.program)?;
                self.check_against(&saved)?;
                self.over(saved)
            }
        };
        plan.check()?;
        Ok(plan)
    }

    /// The caller's settings: `fresh` for a new run, with what `--set` changes, or the saved ones with `--resume`.
    pub fn settings<S: Serialize + DeserializeOwned>(&self, fresh: S) -> Result<S> {
        match &self.resume {
            None if self.set.is_empty() => Ok(fresh),
            None => config::with(&fresh, &self.set),
            Some(folder) => Ok(read_config(folder)?.settings),
        }
    }

    /// Makes the run's folder, or reopens it with `--resume`.
    pub fn open<S: Serialize + DeserializeOwned>(&self, plan: &Plan, settings: &S) -> Result<RunFolder> {
        match (&self.resume, &self.out) {
            (Some(folder), _) => RunFolder::resume(folder, plan, settings),
            (None, Some(folder)) => RunFolder::create(folder, plan, settings),
            (None, None) => RunFolder::create(PathBuf::from("runs").join(plan.folder_name()), plan, settings),
        }
    }

    /// The task that --task or --robot asks for.
    fn task(&self) -> Option<String> {
        self.task.clone().or_else(|| self.robot.as_ref().map(|robot| format!("a/{robot}")))
    }

    fn over(&self, mut plan: Plan) -> Plan {
        let run = &mut plan.run;
        set(&mut plan.task, &self.task());
        plan.order = self.order.clone().or(plan.order);
        set(&mut plan.engine, &self.engine);
        set(&mut plan.preset, &self.preset);
        set(&mut plan.projection, &self.projection);
        set(&mut plan.threads, &self.threads);
        set(&mut run.steps, &self.steps);
        set(&mut run.seed, &self.seed);
        set(&mut run.eval_every, &self.eval_every);
        set(&mut run.eval_episodes, &self.eval_episodes);
        set(&mut run.checkpoint_every, &self.checkpoint_every);
        set(&mut run.log_every, &self.log_every);
        plan
    }

    fn check_against(&self, saved: &Plan) -> Result<()> {
        let run = &saved.run;
        check_given("--task", &self.task(), &saved.task)?;
        match (&self.order, &saved.order) {
            (given, Some(saved)) => check_given("--order", given, saved)?,
            (Some(given), None) => {
                return Err(Error::invalid("--order with --resume", "the task's (leave it out)", given));
            }
            (None, None) => {}
        }
        check_given("--engine", &self.engine, &saved.engine)?;
        check_given("--preset", &self.preset, &saved.preset)?;
        check_given("--projection", &self.projection, &saved.projection)?;
        check_given("--seed", &self.seed, &run.seed)?;
        check_given("--eval-every", &self.eval_every, &run.eval_every)?;
        check_given("--eval-episodes", &self.eval_episodes, &run.eval_episodes)?;
        check_given("--checkpoint-every", &self.checkpoint_every, &run.checkpoint_every)?;
        check_given("--log-every", &self.log_every, &run.log_every)?;
        match self.steps {
            Some(steps) if steps < run.steps => {
                Err(Error::invalid("--steps with --resume", format!("at least the run's {}", run.steps), steps))
            }
            _ => Ok(()),
        }
    }
}

fn set<T: Clone>(value: &mut T, given: &Option<T>) {
    if let Some(given) = given {
        value.clone_from(given);
    }
}

fn check_given<T: PartialEq + ToString>(option: &str, given: &Option<T>, saved: &T) -> Result<()> {
    given.as_ref().map_or(Ok(()), |given| check_equal(option, given, saved))
}

fn check_program(this: &str, saved: &str) -> Result<()> {
    if this == saved {
        return Ok(());
    }
    Err(Error::invalid(
        "--resume",
        format!("a run of {this}"),
        format!("one of {saved}, which {saved} --resume goes on with"),
    ))
}

fn check_equal<T: PartialEq + ToString>(option: &str, given: &T, saved: &T) -> Result<()> {
    if given == saved {
        return Ok(());
    }
    let wanted = format!("the run's own {} (leave it out)", saved.to_string());
    Err(Error::invalid(format!("{option} with --resume"), wanted, given.to_string()))
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::*;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        args: Args,
    }

    fn parse(line: &str) -> Args {
        Cli::try_parse_from(line.split(' ')).unwrap().args
    }

    #[test]
    fn options_go_over_the_programs_defaults() {
        Cli::command().debug_assert();
        let plan = parse("td3 --robot ant --steps 500 --seed 3").plan(Plan::new("td3")).unwrap();
        assert_eq!((plan.task.as_str(), plan.run.steps, plan.run.eval_episodes), ("a/ant", 500, 10));
        assert_eq!(plan.folder_name(), "td3-a-ant-cholesky-s3");
        let plan = parse("td3 --engine mujoco --preset paper").plan(Plan::new("td3")).unwrap();
        assert_eq!(plan.folder_name(), "td3-a-hopper-mujoco-paper-cholesky-s0");
        let message = parse("td3 --log-every 0").plan(Plan::new("td3")).unwrap_err().to_string();
        assert_eq!(message, "log-every: wanted at least 1, got 0");
        assert!(Cli::try_parse_from(["td3", "--out", "a", "--resume", "b"]).is_err());
        assert!(Cli::try_parse_from(["td3", "--task", "a/ant", "--robot", "ant"]).is_err());
    }

    #[test]
    fn resume_takes_the_saved_plan_and_lets_only_the_steps_grow() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path().join("run");
        let plan = parse("td3 --steps 500 --seed 3").plan(Plan::new("td3")).unwrap();
        drop(RunFolder::create(&folder, &plan, &toml::Table::new()).unwrap());
        let resume = |options: &str| {
            parse(&format!("td3 --resume {}{options}", folder.display())).plan(Plan::new("td3")).map(|plan| plan.run)
        };
        assert_eq!(resume("").unwrap(), plan.run);
        assert_eq!(resume(" --steps 900 --seed 3").unwrap().steps, 900);
        let message = |options: &str| resume(options).unwrap_err().to_string();
        assert_eq!(message(" --seed 4"), "--seed with --resume: wanted the run's own 3 (leave it out), got 4");
        assert_eq!(message(" --steps 400"), "--steps with --resume: wanted at least the run's 500, got 400");
        assert!(message("x").contains("x': wanted the folder of a run, got nothing of that name"));
        assert_eq!(message(" --order vsc"), "--order with --resume: wanted the task's (leave it out), got vsc");
        let other = parse(&format!("redq --resume {}", folder.display())).plan(Plan::new("redq")).unwrap_err();
        let wanted = "--resume: wanted a run of redq, got one of td3, which td3 --resume goes on with";
        assert_eq!(other.to_string(), wanted);
    }

    #[test]
    fn a_setting_is_set_by_its_name_in_the_configuration() {
        let set = |options: &str| parse(&format!("td3 {options}")).settings(copq::Config::cop_td3_oac());
        let options = "--set batch=64 --set networks.hidden=[8,8] --set optimism.projection=extremum --set tau=1";
        let config = set(options).unwrap();
        assert_eq!((config.batch, config.networks.hidden, config.tau), (64, vec![8, 8], 1.0));
        assert_eq!(config.optimism.unwrap().projection.as_deref(), Some("extremum"));
        let message = |options: &str| set(options).unwrap_err().to_string();
        assert!(message("--set bath=64").contains("--set: unknown field `bath`, expected one of `discount`"));
        assert!(message("--set networks.hiden=3").contains("unknown field `hiden`"));
        assert!(message("--set batch=many").contains("invalid type: string \"many\", expected usize"));
        assert_eq!(
            message("--set batch.size=1"),
            "--set batch.size=1: wanted a setting that has parts, got 256 at batch"
        );
        assert_eq!(message("--set batch"), "--set batch: wanted KEY=VALUE, got no =");
        let config = set("--set famo=none --set optimism.beta=2").unwrap();
        assert_eq!((config.famo, config.optimism.map(|optimism| optimism.beta)), (None, Some(2.0)));
        assert!(message("--set batch=none").contains("missing field `batch`"));
        let wanted = "--set networks.activation=none: wanted one of its values, such as \"relu\", got none";
        assert_eq!(message("--set networks.activation=none"), wanted);
        for (key, known) in [
            ("networks.activation", "`relu`, `tanh`, `silu`"),
            ("networks.init", "`torch` or `lecun`"),
            ("warm_up", "`uniform` or `policy`"),
            ("famo.decay", "`decoupled` or `l2`"),
        ] {
            let message = message(&format!("--set {key}=other"));
            assert!(message.contains("unknown variant `other`") && message.contains(known), "{message}");
        }
        assert_eq!(message("--set fmo=none"), "--set fmo=none: wanted a setting that there is, got none at fmo");
        assert_eq!(set("--steps 5").unwrap(), copq::Config::cop_td3_oac());
    }
}
