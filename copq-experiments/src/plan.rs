//! What a run does: the task, the parts to swap, and how long and how often.

use std::collections::BTreeMap;
use std::path::PathBuf;

use copq::{Config, Ensemble, Error, Method, Result, on_policy, projection};
use serde::{Deserialize, Serialize};

/// More than any update can use.
const MAX_THREADS: usize = 256;
/// More checkpoints than anybody looks at.
pub(crate) const MAX_KEEP: usize = 100;
/// The usual engine and robots.
const ENGINE: &str = "rapier";
const PRESET: &str = "gym-v5";

/// Names of a run's parts, and its length. The caller turns the names into an environment and an
/// agent.
///
/// ```
/// use copq::{Method, projection::Extremum};
/// use copq_experiments::{Plan, RunSettings};
///
/// let method = Method::cop_td3().bound(Extremum);
/// let plan = Plan {
///     task: "a/walker2d".to_owned(),
///     order: Some("vsc".to_owned()),
///     run: RunSettings { seed: 3, ..RunSettings::default() },
///     ..Plan::new(&method)
/// };
/// plan.check()?;
/// assert_eq!(plan.folder_name(), "cop-td3-a-walker2d-vsc-extremum-s3");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// What it learns by, such as `cop-td3`.
    pub method: String,
    /// Robot and task, such as `a/hopper`.
    pub task: String,
    /// Another priority order of the task's objectives, such as `vsc`, if any.
    pub order: Option<String>,
    /// Other limits of the task's costs than its own, if any.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub limits: BTreeMap<String, f64>,
    /// The physics engine.
    pub engine: String,
    /// Whose robots: the name of a preset such as `gym-v5`.
    pub preset: String,
    /// The bound of the critics' values that targets use, such as `cholesky`; on-policy methods
    /// have none.
    #[serde(default)]
    pub bound: Option<String>,
    /// The critics that it is of.
    #[serde(default)]
    pub critics: Option<Ensemble>,
    /// Other weights of the objectives than the task's own, such as `control=0.5` or `1,1,0.5`, if
    /// any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
    /// What its world is made with, where the task's name does not say it all; the caller's.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub world: toml::Table,
    /// The interpreter of a world that is another program's; it may be another one when the run
    /// goes on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub python: Option<PathBuf>,
    /// Longest silence of such a world in seconds, if it is not the usual one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub env_timeout: Option<f64>,
    /// Versions that the world's numbers depend on, as it told them when the run began.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub versions: Option<String>,
    /// The run's folder or policy's file that its policy begins with, if it does not begin anew.
    #[serde(default)]
    pub init_from: Option<PathBuf>,
    /// What that policy was when the run began: its [`policy_checksum`](crate::policy_checksum).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub init_checksum: Option<String>,
    /// Worlds that take their steps together.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub envs: usize,
    /// Threads inside the run.
    pub threads: usize,
    /// How long and how often.
    pub run: RunSettings,
}

/// How long a run is and how often it does what; everything is counted in environment steps.
///
/// ```
/// use copq_experiments::RunSettings;
///
/// let short = RunSettings { steps: 2_000, eval_every: 500, ..RunSettings::default() };
/// short.check()?;
/// let without_log = RunSettings { log_every: 0, ..short };
/// let error = without_log.check().unwrap_err();
/// assert_eq!(error.to_string(), "log-every: wanted at least 1, got 0");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RunSettings {
    /// Environment steps of training.
    pub steps: u64,
    /// Seed of every random number: networks, exploration, batches, episodes.
    pub seed: u64,
    /// Steps between two evaluations; 0 means never. There is also one at step 0, and one at the
    /// end.
    pub eval_every: u64,
    /// Episodes of an evaluation, the same ones every time.
    pub eval_episodes: usize,
    /// Steps that a row of `metrics.csv` averages over.
    pub log_every: u64,
    /// Steps between two checkpoints.
    pub checkpoint_every: u64,
    /// Checkpoints that stay, the newest among them.
    pub keep: usize,
    /// Which checkpoints hold the replay, most of their size.
    pub replay: SavedReplay,
    /// What to do when the environment fails.
    pub on_env_error: OnEnvError,
    /// What becomes of the episode that runs when the run stops.
    #[serde(skip_serializing_if = "is_exact")]
    pub on_resume: OnResume,
}

/// Where a run goes on.
///
/// ```
/// use copq_experiments::{OnEnvError, OnResume, RunSettings, SavedReplay};
///
/// // For a simulator that fails now and then and cannot be saved, and a small disk.
/// let settings = RunSettings {
///     on_resume: OnResume::NewEpisode,
///     on_env_error: OnEnvError::Reset,
///     replay: SavedReplay::Last,
///     ..RunSettings::default()
/// };
/// let text = toml::to_string(&settings)?; // as config.toml has it
/// assert!(text.contains("replay = \"last\"\non_env_error = \"reset\"\n"));
/// assert!(text.ends_with("on_resume = \"new_episode\"\n"));
/// # Ok::<(), toml::ser::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnResume {
    /// In the middle of the episode: a run that stopped is, bit for bit, one that did not.
    #[default]
    SameEpisode,
    /// With a new episode, for environments that cannot be saved; networks, replay, random numbers
    /// and all else go on where they were. A run that stopped is then as good as one that did not,
    /// but not the same.
    NewEpisode,
}

/// Which checkpoints hold the replay; there is an example at [`OnResume`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SavedReplay {
    /// None. A run that goes on is not what it would have been: it gathers as much experience anew
    /// as before its first update, by the policy that it has, and then learns on.
    None,
    /// The newest; the older ones go on as with `None`.
    Last,
    /// All: a run goes on from each bit for bit.
    #[default]
    All,
}

/// What a run does when its environment fails, as an unstable simulation can; there is an example
/// at [`OnResume`].
///
/// Either way the episode counts as truncated at its last good step, and the run can go on with a
/// new one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnEnvError {
    /// Save, and end with the error.
    #[default]
    Stop,
    /// Say so, count it in `metrics.csv` (`env_errors`), and begin the next episode.
    Reset,
}

fn one() -> usize {
    1
}

// As serde calls it.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_exact(on_resume: &OnResume) -> bool {
    *on_resume == OnResume::SameEpisode
}

// As serde calls it.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_one(count: &usize) -> bool {
    *count == 1
}

impl Default for RunSettings {
    /// 150,000 steps, after which the default's five seeds stand, and the cadence of the
    /// literature: 10 episodes every 5,000.
    fn default() -> Self {
        Self {
            steps: 150_000,
            seed: 0,
            eval_every: 5_000,
            eval_episodes: 10,
            log_every: 1_000,
            checkpoint_every: 20_000,
            keep: 2,
            replay: SavedReplay::All,
            on_env_error: OnEnvError::Stop,
            on_resume: OnResume::SameEpisode,
        }
    }
}

impl RunSettings {
    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        let counts = [
            ("steps", self.steps),
            ("eval-episodes", self.eval_episodes as u64),
            ("log-every", self.log_every),
            ("checkpoint-every", self.checkpoint_every),
        ];
        if !(1..=MAX_KEEP).contains(&self.keep) {
            return Err(Error::invalid("keep", format!("1 to {MAX_KEEP}"), self.keep));
        }
        if let Some((name, _)) = counts.iter().find(|(_, count)| *count == 0) {
            return Err(Error::invalid(*name, "at least 1", 0));
        }
        Ok(())
    }
}

impl Plan {
    /// A method with its bound and critics on Gymnasium's `a/hopper`, on rapier, with one thread.
    pub fn new(method: &Method) -> Self {
        Self {
            bound: Some(method.bound.name().to_owned()),
            critics: Some(method.critics),
            ..Self::on_policy(&method.name)
        }
    }

    /// A method of that name without a bound, the rest as in [`Plan::new`].
    pub fn on_policy(method: impl Into<String>) -> Self {
        Self {
            method: method.into(),
            task: "a/hopper".to_owned(),
            order: None,
            limits: BTreeMap::new(),
            engine: ENGINE.to_owned(),
            preset: PRESET.to_owned(),
            bound: None,
            critics: None,
            weights: None,
            world: toml::Table::new(),
            python: None,
            env_timeout: None,
            versions: None,
            init_from: None,
            init_checksum: None,
            envs: 1,
            threads: 1,
            run: RunSettings::default(),
        }
    }

    /// The method of an off-policy run, with its settings. An error for an on-policy method, and
    /// for one that is not copq's own.
    ///
    /// ```
    /// use copq::Method;
    /// use copq_experiments::Plan;
    ///
    /// let method = Method::cop_cal();
    /// let again = Plan::new(&method).off_policy_method(method.config.clone())?;
    /// assert_eq!((again.name, again.critics), (method.name, method.critics));
    ///
    /// let error = Plan::on_policy("ppo").off_policy_method(method.config).unwrap_err();
    /// assert!(error.to_string().starts_with("the run: wanted one by an off-policy method"));
    /// # Ok::<(), copq::Error>(())
    /// ```
    pub fn off_policy_method(&self, settings: Config) -> Result<Method> {
        let what = "the run";
        if on_policy::Method::by_name(&self.method).is_ok() {
            let got = format!("one by {}", self.method);
            return Err(Error::invalid(what, "one by an off-policy method", got));
        }
        let method = Method::by_name(&self.method).map_err(|_| {
            let got = format!("one of '{}', which another program trains", self.method);
            Error::invalid(what, "one of copq's own methods (copq methods)", got)
        })?;
        let mut method = match &self.bound {
            Some(bound) if bound != method.bound.name() => {
                method.bound(projection::by_name(bound)?)
            }
            _ => method,
        };
        method.critics = self.critics.unwrap_or(method.critics);
        method.config = settings;
        Ok(method)
    }

    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        if !(1..=MAX_THREADS).contains(&self.threads) {
            return Err(Error::invalid("threads", format!("1 to {MAX_THREADS}"), self.threads));
        }
        if self.envs == 0 {
            return Err(Error::invalid("envs", "at least 1", 0));
        }
        self.run.check()
    }

    /// The same with everything as usual that changes no number of a run, or is not known before it
    /// begins: how it is kept, on how many threads it works, whose interpreter it has.
    pub(crate) fn without_keeping(&self) -> Self {
        let RunSettings { keep, replay, on_env_error, checkpoint_every, .. } =
            RunSettings::default();
        let run = RunSettings { keep, replay, on_env_error, checkpoint_every, ..self.run };
        Self { threads: 1, run, python: None, env_timeout: None, versions: None, ..self.clone() }
    }

    /// Whether two runs differ in nothing but seed, length and cadence.
    pub(crate) fn is_seed_of(&self, other: &Self) -> bool {
        let plain = |plan: &Self| Self { run: RunSettings::default(), ..plan.without_keeping() };
        plain(self) == plain(other)
    }

    /// A folder's name that tells runs apart: `cop-td3-a-hopper-cholesky-s0`, or
    /// `cop-td3-a-hopper-mujoco-paper-cholesky-s0` if engine and preset are not the usual ones.
    pub fn folder_name(&self) -> String {
        let mut name = format!("{}-{}", self.method, self.task.replace(['/', '\\', ':'], "-"));
        if let Some(order) = &self.order {
            name += &format!("-{}", order.replace([',', ' '], "-"));
        }
        for (cost, limit) in &self.limits {
            name += &format!("-{cost}{limit}");
        }
        if let Some(weights) = &self.weights {
            name += &format!("-weights-{}", weights.replace([',', ' ', '='], "-"));
        }
        // A task with a colon says itself whose it is.
        let engine = if self.task.contains(':') { ENGINE } else { self.engine.as_str() };
        for (part, usual) in [(engine, ENGINE), (self.preset.as_str(), PRESET)] {
            if part != usual {
                name += &format!("-{part}");
            }
        }
        if self.envs > 1 {
            name += &format!("-{}envs", self.envs);
        }
        if let Some(bound) = &self.bound {
            name += &format!("-{bound}");
        }
        format!("{name}-s{}", self.run.seed)
    }
}
