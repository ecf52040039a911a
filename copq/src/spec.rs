//! The description of an environment: sizes, bounds, and objectives in priority order.

use crate::{Error, Outcome, Result};

/// One component of the reward vector.
///
/// ```
/// use copq::{EnvSpec, Objective};
///
/// // No multiplier weights this cost: it has its own weight.
/// let heat = Objective::cost("heat", 50.0).weight(-0.1);
/// let spec = EnvSpec::new("arm", 4, 2).objective(heat).reward("progress", 1.0);
/// spec.check()?;
/// assert_eq!((spec.weights(), spec.limit(0)), (vec![-0.1, 1.0], Some(50.0)));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Objective {
    /// A short name such as `safety`.
    pub name: String,
    /// Its scalarisation weight w, not normalised (paper Table 1); at most 0 for a cost.
    pub weight: f32,
    /// The limit of a cost's undiscounted sum over an episode; `None` makes it a reward. A cost is
    /// reported as a positive number.
    pub limit: Option<f32>,
}

impl Objective {
    /// A reward with its weight.
    pub fn reward(name: impl Into<String>, weight: f32) -> Self {
        Self { name: name.into(), weight, limit: None }
    }

    /// A cost with its limit, and weight 0. Only methods with a [`Constraint`](crate::Constraint),
    /// such as [`Method::cop_cal`](crate::Method::cop_cal), enforce the limit, with a multiplier.
    /// For other methods, it counts as much as the negative weight that you give it. With them, put
    /// a cost of weight 0 last: [`Cholesky`](crate::projection::Cholesky) lowers the objectives
    /// after it only by what the cost's disagreement does not explain.
    pub fn cost(name: impl Into<String>, limit: f32) -> Self {
        Self { name: name.into(), weight: 0.0, limit: Some(limit) }
    }

    /// Whether it is a cost under a limit.
    pub fn is_cost(&self) -> bool {
        self.limit.is_some()
    }

    /// Sets a different weight, such as a negative one for a cost that no multiplier weights.
    pub fn weight(self, weight: f32) -> Self {
        Self { weight, ..self }
    }
}

/// What an environment is, fixed for its lifetime.
///
/// ```
/// use copq::EnvSpec;
///
/// // A cart that sees 2 numbers and pushes with 1, for 200 steps. In priority order: no crash
/// // first, then progress.
/// let spec = EnvSpec::new("cart", 2, 1)
///     .reward("safety", 1.0)
///     .reward("progress", 1.0)
///     .horizon(200);
/// spec.check()?;
///
/// // A cost has a limit; forces here are in newtons.
/// let spec = EnvSpec::new("cart", 2, 1)
///     .cost("speed", 740.2)
///     .reward("progress", 1.0)
///     .action_bounds(&[-10.0], &[10.0]);
/// assert_eq!((spec.limit(0), spec.limit(1)), (Some(740.2), None));
/// assert_eq!(spec.costs(), [0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnvSpec {
    /// A short name such as `a/hopper`.
    pub name: String,
    /// Length of an observation.
    pub obs_len: usize,
    /// Lower bound of every action component, in the environment's own units.
    pub action_low: Vec<f32>,
    /// Upper bound of every action component.
    pub action_high: Vec<f32>,
    /// The objectives (rewards and costs), highest priority first.
    pub objectives: Vec<Objective>,
    /// The reward that a stochastic policy's entropy bonus is added to, by its name; `None` means
    /// the last reward. The bonus counts with that reward's weight, which must be positive.
    pub entropy: Option<String>,
    /// Steps of the longest episode. The environment itself must then return
    /// [`Outcome::Truncated`](crate::Outcome::Truncated): no caller counts for it, and it is an
    /// error to continue.
    pub horizon: usize,
    /// Versions that its numbers depend on, such as `mujoco 3.17.0`, if it reports them.
    pub versions: Option<String>,
}

impl EnvSpec {
    /// An environment with observations of `obs_len` numbers and actions of `action_len` numbers
    /// from -1 to 1, in episodes of at most 1,000 steps. It needs at least one objective.
    pub fn new(name: impl Into<String>, obs_len: usize, action_len: usize) -> Self {
        Self {
            name: name.into(),
            obs_len,
            action_low: vec![-1.0; action_len],
            action_high: vec![1.0; action_len],
            objectives: Vec::new(),
            entropy: None,
            horizon: 1_000,
            versions: None,
        }
    }

    /// Adds a reward, of lower priority than those before.
    pub fn reward(self, name: impl Into<String>, weight: f32) -> Self {
        self.objective(Objective::reward(name, weight))
    }

    /// Adds a cost with its limit over an episode, of lower priority than the objectives before.
    pub fn cost(self, name: impl Into<String>, limit: f32) -> Self {
        self.objective(Objective::cost(name, limit))
    }

    /// Adds an objective, of lower priority than those before.
    pub fn objective(mut self, objective: Objective) -> Self {
        self.objectives.push(objective);
        self
    }

    /// Sets action bounds different from -1 and 1, in the environment's own units.
    pub fn action_bounds(self, low: &[f32], high: &[f32]) -> Self {
        Self { action_low: low.to_vec(), action_high: high.to_vec(), ..self }
    }

    /// The reward that a stochastic policy's entropy bonus is added to; the last one unless named.
    pub fn entropy(self, reward: impl Into<String>) -> Self {
        Self { entropy: Some(reward.into()), ..self }
    }

    /// Sets a different length of the longest episode.
    pub fn horizon(self, horizon: usize) -> Self {
        Self { horizon, ..self }
    }

    /// Versions that its numbers depend on, for anyone who wants to reproduce them.
    pub fn versions(self, versions: impl Into<String>) -> Self {
        Self { versions: Some(versions.into()), ..self }
    }

    /// Length of an action.
    pub fn action_len(&self) -> usize {
        self.action_low.len()
    }

    /// The objectives' names, highest priority first.
    pub fn names(&self) -> Vec<&str> {
        self.objectives.iter().map(|objective| objective.name.as_str()).collect()
    }

    /// The objectives' weights, highest priority first.
    pub fn weights(&self) -> Vec<f32> {
        self.objectives.iter().map(|objective| objective.weight).collect()
    }

    /// The limit of an objective that is a cost.
    pub fn limit(&self, objective: usize) -> Option<f32> {
        self.objectives.get(objective)?.limit
    }

    /// The position of the reward that an entropy bonus is added to; none if there are only costs.
    pub(crate) fn entropy_objective(&self) -> Option<usize> {
        match &self.entropy {
            Some(name) => self.objectives.iter().position(|known| known.name == *name),
            None => (0..self.objectives.len()).rev().find(|&i| self.limit(i).is_none()),
        }
    }

    /// The positions of the costs.
    pub fn costs(&self) -> Vec<usize> {
        (0..self.objectives.len()).filter(|&i| self.objectives[i].is_cost()).collect()
    }

    /// An error for a task without a cost; `what` says what needs one.
    pub(crate) fn check_has_cost(&self, what: &str) -> Result<()> {
        if self.objectives.iter().any(Objective::is_cost) {
            return Ok(());
        }
        let what = format!("{what} on '{}'", self.name);
        Err(Error::invalid(what, "a task with a cost under a limit, such as b/hopper", "none"))
    }

    /// An error for an episode that continues past its horizon: a caller that waits for its end
    /// would wait for ever.
    pub(crate) fn check_length(&self, length: u64, outcome: Outcome) -> Result<()> {
        if outcome != Outcome::Running || length < self.horizon as u64 {
            return Ok(());
        }
        let what = format!(
            "still running after {length} steps; wanted Outcome::Truncated at its horizon, {}",
            self.horizon
        );
        Err(Error::Env { env: self.name.clone(), what })
    }

    /// Maps an action from [-1, 1], the units of policies and replay, to the environment's bounds:
    /// exactly onto them at the ends, and never beyond them.
    pub fn scale_action(&self, unit: &[f32], out: &mut [f32]) {
        for (i, (out, &unit)) in out.iter_mut().zip(unit).enumerate() {
            let low = self.action_low[i];
            let high = self.action_high[i];
            // Halving first keeps finite bounds from overflowing. Centre and half range leave
            // [-1, 1] as it is.
            let scaled = (0.5 * low + 0.5 * high) + (0.5 * high - 0.5 * low) * unit;
            *out = match unit {
                -1.0 => low,
                1.0 => high,
                _ => scaled.clamp(low, high),
            };
        }
    }

    /// An error that names the first difference from another description; `what` says whose that
    /// is. Versions may differ.
    pub fn check_same(&self, what: &str, other: &Self) -> Result<()> {
        let bounds = |spec: &Self| format!("{:?} to {:?}", spec.action_low, spec.action_high);
        let objectives = |spec: &Self| {
            let described = spec.objectives.iter().map(|Objective { name, weight, limit }| {
                let limit = limit.map_or(String::new(), |limit| format!(", limit {limit}"));
                format!("{name} (weight {weight}{limit})")
            });
            described.collect::<Vec<_>>().join(", ")
        };
        for (part, wanted, got) in [
            ("name", self.name.clone(), other.name.clone()),
            ("observation length", self.obs_len.to_string(), other.obs_len.to_string()),
            ("action bounds", bounds(self), bounds(other)),
            ("objectives", objectives(self), objectives(other)),
            (
                "reward of the entropy bonus",
                format!("{:?}", self.entropy),
                format!("{:?}", other.entropy),
            ),
            ("horizon", self.horizon.to_string(), other.horizon.to_string()),
        ] {
            if wanted != got {
                return Err(Error::invalid(format!("{what}: its {part}"), wanted, got));
            }
        }
        Ok(())
    }

    /// An error if the description contradicts itself.
    pub fn check(&self) -> Result<()> {
        if self.obs_len == 0 {
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
            return Err(self.error(
                "action bounds",
                "as many lower as upper bounds, at least 1",
                got,
            ));
        }
        for (i, (low, high)) in self.action_low.iter().zip(&self.action_high).enumerate() {
            if !(low.is_finite() && high.is_finite() && low < high) {
                let got = format!("[{low}, {high}]");
                return Err(self.error(
                    &format!("bounds of action {i}"),
                    "finite, lower < upper",
                    got,
                ));
            }
        }
        Ok(())
    }

    fn check_objectives(&self) -> Result<()> {
        if self.objectives.is_empty() {
            return Err(self.error("objectives", "at least one", "none"));
        }
        if self.objectives.iter().all(|objective| objective.weight == 0.0 && !objective.is_cost()) {
            return Err(self.error("weights", "one at least that is not 0", "only zeros"));
        }
        let names = self.names();
        for (i, Objective { name, weight, .. }) in self.objectives.iter().enumerate() {
            if name.is_empty() || name.contains(char::is_control) {
                let wanted = "a name of one line, for columns and charts";
                return Err(self.error("objectives", wanted, format!("{name:?}")));
            }
            if names[..i].contains(&name.as_str()) {
                return Err(self.error(
                    "objectives",
                    "names that differ",
                    format!("'{name}' twice"),
                ));
            }
            if !weight.is_finite() {
                return Err(self.error(&format!("weight of '{name}'"), "a finite number", weight));
            }
        }
        Ok(())
    }

    fn check_costs(&self) -> Result<()> {
        for Objective { name, weight, limit } in &self.objectives {
            let Some(limit) = limit else { continue };
            if !limit.is_finite() {
                let what = format!("limit of '{name}'");
                return Err(self.error(&what, "a finite number", limit));
            }
            if *weight > 0.0 {
                let what = format!("weight of the cost '{name}'");
                return Err(self.error(
                    &what,
                    "at most 0, as costs are positive and unwanted",
                    weight,
                ));
            }
        }
        Ok(())
    }

    fn error(&self, what: &str, wanted: &str, got: impl ToString) -> Error {
        Error::invalid(format!("{}: {what}", self.name), wanted, got)
    }
}
