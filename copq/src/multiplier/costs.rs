//! The costs of a task under multipliers: limits in the units of Q, estimates, weights, and their
//! logging.

use crate::{EnvSpec, Error, Observer, Result};

/// An episode's limit in the units of a discounted value: `limit (1 - gamma^T) / ((1 - gamma) T)`.
/// This is the value of paying `limit / T` at each of the episode's T steps (paper App. C). For
/// gamma = 1, it is the limit itself.
///
/// ```
/// // Speed limits of hopper, walker2d, ant and humanoid for episodes of 1,000 steps, and their
/// // discounted values, about a tenth of them, as in the paper.
/// let limits = [(740.2, 74.0168), (2341.5, 234.1399), (2622.2, 262.2087), (1411.9, 141.1839)];
/// for (limit, wanted) in limits {
///     assert!((copq::discounted_limit(limit, 0.99, 1000) - wanted).abs() < 5e-5);
/// }
/// ```
pub fn discounted_limit(limit: f64, discount: f64, horizon: usize) -> f64 {
    let steps = horizon as f64;
    if discount == 1.0 {
        return limit;
    }
    limit * (1.0 - libm::pow(discount, steps)) / ((1.0 - discount) * steps)
}

/// Steps of the longest episode that a discounted limit is computed for.
const LONGEST: usize = 1_000_000_000;

/// The costs among a task's objectives, and the weights that their multipliers give.
#[derive(Clone, Debug)]
pub(super) struct Costs {
    costs: Vec<Cost>,
    pub(super) weights: Vec<f32>,
    pub(super) actor_weights: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Cost {
    /// Its position among the objectives.
    objective: usize,
    /// Its limit, discounted.
    limit: f64,
    /// An episode's cost for each unit of the discounted value.
    per_episode: f64,
    /// Its last estimate.
    estimate: f64,
    names: [String; 4],
}

impl Costs {
    /// The costs of a task; an error if there are none, or if episodes have no end.
    pub(super) fn new(spec: &EnvSpec, discount: f64) -> Result<Self> {
        spec.check()?;
        let cost = |objective: usize| {
            let limit = discounted_limit(f64::from(spec.limit(objective)?), discount, spec.horizon);
            let per_episode = 1.0 / discounted_limit(1.0, discount, spec.horizon);
            let name = &spec.objectives[objective].name;
            let names = ["multiplier", "multiplier_effective", "cost_estimate", "cost_violation"];
            Some(Cost {
                objective,
                limit,
                per_episode,
                estimate: limit,
                names: names.map(|kind| format!("{kind}/{name}")),
            })
        };
        spec.check_has_cost("a constraint")?;
        if spec.horizon > LONGEST {
            let what = format!("horizon of '{}'", spec.name);
            let wanted = "at most a billion steps, since a limit is what an episode may cost";
            return Err(Error::invalid(what, wanted, spec.horizon));
        }
        let costs = (0..spec.objectives.len()).filter_map(cost).collect();
        let weights = spec.weights();
        let actor_weights = spec.weights().iter().map(|&w| w.into()).collect();
        Ok(Self { costs, weights, actor_weights })
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.costs.len()
    }

    /// Takes in the objectives' mean bounds.
    pub(super) fn observe(&mut self, bound: &[f32]) {
        self.costs.iter_mut().for_each(|cost| cost.estimate = bound[cost.objective].into());
    }

    /// The i-th cost's estimate.
    pub(super) fn estimate(&self, i: usize) -> f64 {
        self.costs[i].estimate
    }

    /// The i-th cost's estimate over its limit: positive where the constraint is violated.
    pub(super) fn violation(&self, i: usize) -> f64 {
        self.costs[i].estimate - self.costs[i].limit
    }

    /// The i-th cost's estimate and violation, as the cost of an episode at the same rate.
    pub(super) fn of_episode(&self, i: usize) -> [f64; 2] {
        [self.estimate(i), self.violation(i)].map(|value| value * self.costs[i].per_episode)
    }

    /// Sets the i-th cost's weight in projections. A cost's weight is negative, so that pessimism
    /// raises it.
    pub(super) fn set_weight(&mut self, i: usize, multiplier: f64) {
        self.weights[self.costs[i].objective] = -multiplier as f32;
    }

    /// Sets the i-th cost's weight in the actor's objective.
    pub(super) fn set_actor_weight(&mut self, i: usize, effective: f64) {
        self.actor_weights[self.costs[i].objective] = -effective;
    }

    /// The costs' weights in the actor's objective, as they were set.
    pub(super) fn effective(&self) -> Vec<f64> {
        self.costs.iter().map(|cost| -self.actor_weights[cost.objective]).collect()
    }

    /// Reports multiplier, effective multiplier, estimate and violation of every cost.
    pub(super) fn log(&self, step: u64, log: &mut dyn Observer, multiplier: impl Fn(usize) -> f64) {
        for (i, cost) in self.costs.iter().enumerate() {
            let effective = -self.actor_weights[cost.objective];
            let values = [multiplier(i), effective, cost.estimate, self.violation(i)];
            cost.names.iter().zip(values).for_each(|(name, value)| log.scalar(step, name, value));
        }
    }
}
