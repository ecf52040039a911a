//! The environment: a Markov decision process with a vector of rewards, in priority order.

use crate::{Error, Result, State};

/// How a step left the episode. Only [`Outcome::Terminated`] stops the bootstrap (`d = 1` in the TD target).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The episode goes on.
    Running,
    /// The task itself ended it: the robot fell, the goal was reached.
    Terminated,
    /// Time ran out; the state is as valuable as any other.
    Truncated,
}

/// What an environment is, fixed for its lifetime.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvSpec {
    /// A short name such as `a/hopper`.
    pub name: String,
    /// Length of an observation.
    pub observation: usize,
    /// Lower bound of every action component, in the environment's own units.
    pub action_low: Vec<f32>,
    /// Upper bound of every action component.
    pub action_high: Vec<f32>,
    /// Names of the rewards, highest priority first.
    pub objectives: Vec<String>,
    /// The task's scalarisation weights w, one an objective, not normalised (paper Table 1).
    pub weights: Vec<f32>,
    /// Which objectives are costs: the limit of each one's undiscounted sum over an episode, `None` for a reward. Empty
    /// if the task has no costs. A cost is told as a positive number; its weight is negative, or 0 to leave it to a multiplier.
    pub limits: Vec<Option<f32>>,
    /// Steps after which an episode is truncated at the latest; it is an error to run on.
    pub horizon: usize,
}

impl EnvSpec {
    /// Length of an action.
    pub fn action(&self) -> usize {
        self.action_low.len()
    }

    /// The limit of an objective that is a cost.
    pub fn limit(&self, objective: usize) -> Option<f32> {
        self.limits.get(objective).copied().flatten()
    }

    /// An error for an episode that runs on past its horizon: whoever waits for its end would wait for ever.
    pub(crate) fn check_length(&self, length: u64, outcome: Outcome) -> Result<()> {
        if outcome != Outcome::Running || length < self.horizon as u64 {
            return Ok(());
        }
        let what =
            format!("still running after {length} steps; wanted Outcome::Truncated at its horizon, {}", self.horizon);
        Err(Error::Env { env: self.name.clone(), what })
    }

    /// Maps an action from [-1, 1], the units of policies and replay, to the environment's bounds.
    pub fn scale_action(&self, unit: &[f32], out: &mut [f32]) {
        for (i, (out, unit)) in out.iter_mut().zip(unit).enumerate() {
            let (low, high) = (self.action_low[i], self.action_high[i]);
            // Centre + half range keeps [-1, 1] exact.
            *out = 0.5 * (low + high) + 0.5 * (high - low) * unit;
        }
    }

    /// An error if the description contradicts itself.
    pub fn check(&self) -> Result<()> {
        let name = &self.name;
        let objectives = self.objectives.len();
        let error =
            |what: &str, wanted: String, got: String| Err(Error::invalid(format!("{name}: {what}"), wanted, got));
        if self.observation == 0 {
            return error("observation length", "at least 1".into(), "0".into());
        }
        if self.action_low.is_empty() || self.action_low.len() != self.action_high.len() {
            let got = format!("{} and {}", self.action_low.len(), self.action_high.len());
            return error("action bounds", "as many lower as upper bounds, at least 1".into(), got);
        }
        if let Some(i) = (0..self.action()).find(|&i| {
            let (low, high) = (self.action_low[i], self.action_high[i]);
            !(low.is_finite() && high.is_finite() && low < high)
        }) {
            let got = format!("[{}, {}]", self.action_low[i], self.action_high[i]);
            return error(&format!("bounds of action {i}"), "finite, lower < upper".into(), got);
        }
        if objectives == 0 || self.weights.len() != objectives {
            let got = format!("{objectives} names, {} weights", self.weights.len());
            return error("objectives", "at least one, with a weight each".into(), got);
        }
        if !self.limits.is_empty() && self.limits.len() != objectives {
            let got = format!("{objectives} names, {} limits", self.limits.len());
            return error("cost limits", "none, or an entry for every objective".into(), got);
        }
        if let Some(limit) = self.limits.iter().flatten().find(|limit| !limit.is_finite()) {
            return error("cost limit", "a finite number".into(), limit.to_string());
        }
        if let Some(i) = (0..objectives).find(|&i| self.limit(i).is_some() && self.weights[i] > 0.0) {
            let what = format!("weight of the cost '{}'", self.objectives[i]);
            return error(&what, "at most 0, as costs are positive and unwanted".into(), self.weights[i].to_string());
        }
        if self.horizon == 0 {
            return error("horizon", "at least 1 step".into(), "0".into());
        }
        Ok(())
    }
}

/// An environment with vector rewards. It never resets itself: after an outcome other than
/// [`Outcome::Running`] the caller calls [`Env::reset`].
pub trait Env: Send {
    /// The description, the same at every call.
    fn spec(&self) -> &EnvSpec;

    /// Begins an episode that depends on nothing but `seed`; writes the first observation.
    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()>;

    /// Applies an action within the bounds; writes the next observation and the reward vector, raw (unweighted).
    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome>;

    /// Writes all that [`Env::load`] needs to go on bit for bit, in mid-episode.
    fn save(&self, state: &mut State) -> Result<()>;

    /// Goes back to what [`Env::save`] wrote.
    fn load(&mut self, state: &State) -> Result<()>;
}
