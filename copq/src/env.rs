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
    /// The task's scalarisation weights w, one per objective, not normalised (paper Table 1).
    pub weights: Vec<f32>,
    /// Which objectives are costs: the limit of each one's undiscounted sum over an episode, `None` for a reward. Empty
    /// if the task has no costs. A cost is told as a positive number; its weight is negative, or 0 to leave it to a multiplier.
    pub limits: Vec<Option<f32>>,
    /// The reward that a stochastic policy's entropy bonus is added to, by its name; `None` means the last reward.
    pub entropy: Option<String>,
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

    /// The position of the reward that an entropy bonus is added to; none if there are only costs.
    pub(crate) fn entropy_objective(&self) -> Option<usize> {
        match &self.entropy {
            Some(name) => self.objectives.iter().position(|known| known == name),
            None => (0..self.objectives.len()).rev().find(|&i| self.limit(i).is_none()),
        }
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
        if self.observation == 0 {
            return Err(self.error("observation length", "at least 1", 0));
        }
        if self.horizon == 0 {
            return Err(self.error("horizon", "at least 1 step", 0));
        }
        self.check_actions()?;
        self.check_objectives()?;
        self.check_costs()?;
        match &self.entropy {
            Some(name) if self.entropy_objective().is_none_or(|i| self.limit(i).is_some()) => {
                Err(self.error("objective of the entropy bonus", "one of the rewards", name))
            }
            _ => Ok(()),
        }
    }

    fn check_actions(&self) -> Result<()> {
        if self.action_low.is_empty() || self.action_low.len() != self.action_high.len() {
            let got = format!("{} and {}", self.action_low.len(), self.action_high.len());
            return Err(self.error("action bounds", "as many lower as upper bounds, at least 1", got));
        }
        for (i, (low, high)) in self.action_low.iter().zip(&self.action_high).enumerate() {
            if !(low.is_finite() && high.is_finite() && low < high) {
                let got = format!("[{low}, {high}]");
                return Err(self.error(&format!("bounds of action {i}"), "finite, lower < upper", got));
            }
        }
        Ok(())
    }

    fn check_objectives(&self) -> Result<()> {
        let Self { objectives, weights, .. } = self;
        if objectives.is_empty() || weights.len() != objectives.len() {
            let got = format!("{} names, {} weights", objectives.len(), weights.len());
            return Err(self.error("objectives", "at least one, with a weight each", got));
        }
        for (i, (name, weight)) in objectives.iter().zip(weights).enumerate() {
            if objectives[..i].contains(name) {
                return Err(self.error("objectives", "names that differ", format!("'{name}' twice")));
            }
            if !weight.is_finite() {
                return Err(self.error(&format!("weight of '{name}'"), "a finite number", weight));
            }
        }
        Ok(())
    }

    fn check_costs(&self) -> Result<()> {
        let Self { objectives, weights, limits, .. } = self;
        if !limits.is_empty() && limits.len() != objectives.len() {
            let got = format!("{} names, {} limits", objectives.len(), limits.len());
            return Err(self.error("cost limits", "none, or an entry for every objective", got));
        }
        for (i, limit) in limits.iter().enumerate().filter_map(|(i, limit)| Some((i, (*limit)?))) {
            if !limit.is_finite() {
                return Err(self.error("cost limit", "a finite number", limit));
            }
            if weights[i] > 0.0 {
                let what = format!("weight of the cost '{}'", objectives[i]);
                return Err(self.error(&what, "at most 0, as costs are positive and unwanted", weights[i]));
            }
        }
        Ok(())
    }

    fn error(&self, what: &str, wanted: &str, got: impl ToString) -> Error {
        Error::invalid(format!("{}: {what}", self.name), wanted, got)
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
