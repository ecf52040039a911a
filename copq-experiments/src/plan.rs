//! What a run does: the task, the parts to swap, and how long and how often.

use copq::{Error, Result};
use serde::{Deserialize, Serialize};

/// More than any update can use.
const MAX_THREADS: usize = 256;

/// Names of a run's parts, and its length. The caller turns the names into an environment and an agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// The program that trains, such as `td3`; another program does not resume its runs.
    pub program: String,
    /// What it trains by, if it knows several methods.
    pub method: Option<String>,
    /// Robot and task, such as `a/hopper`.
    pub task: String,
    /// Another priority order of the task's objectives, such as `vsc`, if any.
    pub order: Option<String>,
    /// The physics engine.
    pub engine: String,
    /// Whose robots: the name of a preset such as `gym-v5`.
    pub preset: String,
    /// The projection of vector-valued critics onto a bound, such as `cholesky`.
    pub projection: String,
    /// Threads inside the run.
    pub threads: usize,
    /// How long and how often.
    pub run: RunSettings,
}

/// How long a run is and how often it does what; everything is counted in environment steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunSettings {
    /// Environment steps of training.
    pub steps: u64,
    /// Seed of every random number: networks, exploration, batches, episodes.
    pub seed: u64,
    /// gamma, with which evaluation discounts the returns that it compares with Q-values; the learner's own.
    pub discount: f64,
    /// Steps between two evaluations.
    pub eval_every: u64,
    /// Episodes of an evaluation, the same ones every time.
    pub eval_episodes: usize,
    /// Steps that a row of `metrics.csv` averages over.
    pub log_every: u64,
    /// Steps between two checkpoints.
    pub checkpoint_every: u64,
}

impl Default for RunSettings {
    /// 100,000 steps, and the cadence of the literature: 10 episodes every 5,000.
    fn default() -> Self {
        Self {
            steps: 100_000,
            seed: 0,
            discount: 0.99,
            eval_every: 5_000,
            eval_episodes: 10,
            log_every: 1_000,
            checkpoint_every: 20_000,
        }
    }
}

impl RunSettings {
    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        let counts = [
            ("steps", self.steps),
            ("eval-every", self.eval_every),
            ("eval-episodes", self.eval_episodes as u64),
            ("log-every", self.log_every),
            ("checkpoint-every", self.checkpoint_every),
        ];
        if let Some((name, _)) = counts.iter().find(|(_, count)| *count == 0) {
            return Err(Error::invalid(*name, "at least 1", 0));
        }
        if !(0.0..=1.0).contains(&self.discount) {
            return Err(Error::invalid("discount", "a number from 0 to 1", self.discount));
        }
        Ok(())
    }
}

impl Plan {
    /// The defaults of a program: Gymnasium's `a/hopper` on rapier with the Cholesky projection, one thread.
    pub fn new(program: &str) -> Self {
        Self {
            program: program.to_owned(),
            method: None,
            task: "a/hopper".to_owned(),
            order: None,
            engine: "rapier".to_owned(),
            preset: "gym-v5".to_owned(),
            projection: "cholesky".to_owned(),
            threads: 1,
            run: RunSettings::default(),
        }
    }

    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        if !(1..=MAX_THREADS).contains(&self.threads) {
            return Err(Error::invalid("threads", format!("1 to {MAX_THREADS}"), self.threads));
        }
        self.run.check()
    }

    /// Whether two runs differ in nothing but seed, length and cadence.
    pub(crate) fn is_seed_of(&self, other: &Self) -> bool {
        let plain = |plan: &Self| Self { threads: 1, run: RunSettings::default(), ..plan.clone() };
        plain(self) == plain(other)
    }

    /// The method's name, which is the program's if it has but one.
    pub fn method(&self) -> &str {
        self.method.as_deref().unwrap_or(&self.program)
    }

    /// A folder's name that tells runs apart: `td3-a-hopper-cholesky-s0`, or `td3-a-hopper-mujoco-paper-cholesky-s0` if engine
    /// and preset are not the usual ones.
    pub fn folder_name(&self) -> String {
        let usual = Self::new(&self.program);
        let mut name = format!("{}-{}", self.method(), self.task.replace(['/', '\\'], "-"));
        if let Some(order) = &self.order {
            name += &format!("-{}", order.replace([',', ' '], "-"));
        }
        for (part, usual) in [(&self.engine, usual.engine), (&self.preset, usual.preset)] {
            if *part != usual {
                name += &format!("-{part}");
            }
        }
        format!("{name}-{}-s{}", self.projection, self.run.seed)
    }
}
