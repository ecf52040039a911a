//! What an environment's name does not say.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// How an environment is made and viewed. The default suits most: the environment's own arguments,
/// and its one reward called `reward`.
///
/// ```no_run
/// use copq_envs_python::{Options, make_with};
///
/// let options = Options {
///     python: Some(".venv/bin/python".into()),
///     objectives: ["forward", "jump", "control"].map(str::to_owned).to_vec(),
///     kwargs: r#"{"forward_reward_weight": 2.0}"#.to_owned(),
///     ..Options::default()
/// };
/// let env = make_with("mo-gymnasium:mo-hopper-v5", &options)?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// The interpreter that has the environment's package; without one, the interpreter that the
    /// variable `COPQ_PYTHON` names, or else `python3`.
    #[serde(skip)]
    pub python: Option<PathBuf>,
    /// Names of the rewards in the environment's order, in place of `reward` or `reward.0`,
    /// `reward.1` and so on. For Safety-Gymnasium the cost's name comes first, in place of `cost`
    /// and `reward`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objectives: Vec<String>,
    /// Limits of an episode's costs, by name. These objectives are costs, reported as positive
    /// numbers. Without a limit here, Safety-Gymnasium's `cost` has the limit 25 (its benchmark's).
    #[serde(skip)]
    pub limits: BTreeMap<String, f64>,
    /// Arguments that the environment is made with, as JSON.
    #[serde(skip_serializing_if = "is_empty")]
    pub kwargs: String,
    /// Modules to import first, by name or as a file `PATH.py`. They register the user's
    /// environments.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub imports: Vec<String>,
    /// Longest silence before a reset or a step counts as failed, in seconds; a start may take five
    /// times as long.
    #[serde(skip, default = "minute")]
    pub timeout: f64,
    /// Whether it can be drawn ([`PythonEnv::picture`](crate::PythonEnv::picture)).
    #[serde(skip)]
    pub render: bool,
}

/// The limit of Safety-Gymnasium's cost in OmniSafe's benchmark.
const USUAL_LIMIT: f64 = 25.0;

impl Options {
    /// Adds the usual limit of a task's own cost, unless it has another.
    ///
    /// ```
    /// use copq_envs_python::Options;
    ///
    /// let options = Options::default().with_usual_limit("safety-gymnasium:SafetyPointGoal1-v0");
    /// assert_eq!(options.limits["cost"], 25.0);
    /// ```
    pub fn with_usual_limit(mut self, task: &str) -> Self {
        if task.starts_with("safety-gymnasium:") {
            let cost = self.objectives.first().map_or("cost", String::as_str).to_owned();
            self.limits.entry(cost).or_insert(USUAL_LIMIT);
        }
        self
    }
}

fn is_empty(kwargs: &str) -> bool {
    kwargs == "{}"
}

fn minute() -> f64 {
    60.0
}

impl Default for Options {
    fn default() -> Self {
        Self {
            python: None,
            objectives: Vec::new(),
            limits: BTreeMap::new(),
            kwargs: "{}".to_owned(),
            imports: Vec::new(),
            timeout: minute(),
            render: false,
        }
    }
}
