//! Checks that observations and rewards have a size that float32 networks can learn from, and that
//! costs have the right sign.

use crate::{EnvSpec, Error, Observer, Result};

/// Networks learn badly from numbers beyond this: they are made for inputs and values near 1.
pub(crate) const LARGE: f32 = 1e4;

/// Rewards beyond this cannot be learned: values are sums of many rewards, and the squares of their
/// gradients, Adam's second moments, must stay below 3e38.
const HOPELESS: f32 = 1e15;

/// Steps over which a cost is added up before its sign is judged: a speed, for example, is negative
/// while a robot falls backwards.
const WHILE: u64 = 1_000;

/// The largest sizes so far, the sums of the costs, and whether a warning was given about them.
#[derive(Clone, Debug)]
pub(crate) struct Scales {
    obs: f32,
    reward: f32,
    has_warned: bool,
    /// Steps observed.
    steps: u64,
    costs: Vec<Cost>,
}

/// One of the objectives under a limit.
#[derive(Clone, Debug)]
struct Cost {
    index: usize,
    name: String,
    sum: f64,
    has_warned: bool,
}

impl Scales {
    pub(crate) fn new(spec: &EnvSpec) -> Self {
        let name = |index: usize| spec.objectives[index].name.clone();
        let cost = |index| Cost { index, name: name(index), sum: 0.0, has_warned: false };
        let costs = spec.costs().into_iter().map(cost).collect();
        Self { obs: 0.0, reward: 0.0, has_warned: false, steps: 0, costs }
    }

    /// Takes in what an environment returned; an error for rewards that no network can learn from.
    pub(crate) fn observe(&mut self, obs: &[f32], reward: &[f32]) -> Result<()> {
        let largest = size(reward);
        if largest > HOPELESS {
            let wanted = format!("at most {HOPELESS:e}, so that squares of values fit float32");
            return Err(Error::invalid("size of the rewards", wanted, format!("{largest:e}")));
        }
        self.obs = size(obs).max(self.obs);
        self.reward = largest.max(self.reward);
        if self.steps < WHILE {
            self.steps += 1;
            self.costs.iter_mut().for_each(|cost| cost.sum += f64::from(reward[cost.index]));
        }
        Ok(())
    }

    /// Warns once about sizes that are too large, and once about each cost with a negative sum.
    pub(crate) fn warn(&mut self, step: u64, is_normalised: bool, log: &mut dyn Observer) {
        let seen = self.costs.iter_mut().filter(|_| self.steps == WHILE);
        for cost in seen.filter(|cost| cost.sum < 0.0 && !cost.has_warned) {
            cost.has_warned = true;
            log.warn(step, &negative_cost(&cost.name, cost.sum));
        }
        let obs = if is_normalised { 0.0 } else { self.obs };
        if self.has_warned || obs.max(self.reward) <= LARGE {
            return;
        }
        self.has_warned = true;
        if obs > LARGE {
            log.warn(step, &large_obs(obs));
        }
        if self.reward > LARGE {
            log.warn(step, &large_reward(self.reward));
        }
    }
}

pub(crate) fn size(values: &[f32]) -> f32 {
    values.iter().fold(0.0, |most, x| x.abs().max(most))
}

pub(crate) fn large_obs(size: f32) -> String {
    format!(
        "observations reach {size:.1e}, and networks learn from numbers near 1: scale them, or let \
         the method normalise them (Config::normalise)"
    )
}

pub(crate) fn large_reward(size: f32) -> String {
    format!("rewards reach {size:.1e}, and networks learn values near 1 to 1,000: scale them")
}

fn negative_cost(name: &str, sum: f64) -> String {
    format!(
        "the cost '{name}' added up to {sum:.1} in {WHILE} steps: a limit is an upper bound on \
         a cost that counts up from 0, and a negative cost never exceeds it"
    )
}
