//! What a run does: the task, the parts to swap, and how long and how often.

use std::collections::BTreeMap;
use std::path::PathBuf;

use copq::{Config, Ensemble, Error, Method, Result, on_policy, projection};
use serde::{Deserialize, Serialize};

use crate::settings::RunSettings;

/// More threads than any update can use.
const MAX_THREADS: usize = 256;
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
    /// The method that it learns by, such as `cop-td3`.
    pub method: String,
    /// Robot and task, such as `a/hopper`.
    pub task: String,
    /// A priority order of the objectives in place of the task's own, such as `vsc`, if any.
    pub order: Option<String>,
    /// Limits of the task's costs in place of its own, if any.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub limits: BTreeMap<String, f64>,
    /// The physics engine.
    pub engine: String,
    /// Which version of the robots: the name of a preset such as `gym-v5`.
    pub preset: String,
    /// The bound of the critics' values that targets use, such as `cholesky`; on-policy methods
    /// have none.
    #[serde(default)]
    pub bound: Option<String>,
    /// The critics that the bound is of.
    #[serde(default)]
    pub critics: Option<Ensemble>,
    /// Weights of the objectives in place of the task's own, such as `control=0.5` or `1,1,0.5`, if
    /// any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
    /// What its environment is made with, if the task's name does not say it all; the caller
    /// defines it.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub world: toml::Table,
    /// The interpreter of an environment that is another program's; it may be a different one when
    /// the run resumes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub python: Option<PathBuf>,
    /// Longest silence of such an environment in seconds, if it is not the usual one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub env_timeout: Option<f64>,
    /// Versions that the environment's numbers depend on, as it reported them when the run began.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub versions: Option<String>,
    /// The run folder or policy file that its policy starts from, if it does not start from
    /// scratch.
    #[serde(default)]
    pub init_from: Option<PathBuf>,
    /// What that policy was when the run began: its [`policy_checksum`](crate::policy_checksum).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub init_checksum: Option<String>,
    /// Environments that take their steps together.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub envs: usize,
    /// Threads inside the run.
    pub threads: usize,
    /// How long and how often.
    pub run: RunSettings,
}

fn one() -> usize {
    1
}

// As serde calls it.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_one(count: &usize) -> bool {
    *count == 1
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
    /// assert!(error.to_string().starts_with("the run's method: wanted an off-policy one"));
    /// # Ok::<(), copq::Error>(())
    /// ```
    pub fn off_policy_method(&self, settings: Config) -> Result<Method> {
        let what = "the run's method";
        if on_policy::Method::by_name(&self.method).is_ok() {
            return Err(Error::invalid(what, "an off-policy one", &self.method));
        }
        let method = Method::by_name(&self.method).map_err(|_| {
            let got = format!("'{}', which another program trains", self.method);
            Error::invalid(what, "one of copq's own (copq methods lists them)", got)
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

    /// Where it ends at the latest: several environments may go beyond the last step that is
    /// wanted.
    pub(crate) fn last_step(&self) -> u64 {
        self.run.steps.saturating_add(self.envs.max(1) as u64 - 1)
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

    /// The same plan with defaults for everything that changes no number of a run, or is not known
    /// before it begins: how it is kept, how many threads it uses, which interpreter it has.
    pub(crate) fn without_keeping(&self) -> Self {
        let RunSettings { keep, replay, on_env_error, checkpoint_every, .. } =
            RunSettings::default();
        let run = RunSettings { keep, replay, on_env_error, checkpoint_every, ..self.run };
        Self { threads: 1, run, python: None, env_timeout: None, versions: None, ..self.clone() }
    }

    /// The same plan without its length, with defaults for everything that changes no number.
    pub(crate) fn without_length(&self) -> Self {
        let plan = self.without_keeping();
        Self { run: RunSettings { steps: RunSettings::default().steps, ..plan.run }, ..plan }
    }

    /// Whether two runs differ only in seed, length and cadence.
    pub(crate) fn is_seed_of(&self, other: &Self) -> bool {
        let plain = |plan: &Self| Self { run: RunSettings::default(), ..plan.without_keeping() };
        plain(self) == plain(other)
    }

    /// A folder name that tells runs apart: `cop-td3-a-hopper-cholesky-s0`, or
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
        // A task with a colon names its own package.
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
