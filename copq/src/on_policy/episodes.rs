//! What the learner stores about episodes: where each environment is, and what finished episodes
//! cost.

use super::epoch::Taken;
use crate::EnvSpec;

/// One environment's episode as the learner has seen it.
#[derive(Clone, Debug)]
pub(super) struct EnvState {
    /// The step that was chosen last.
    pub taken: Taken,
    /// Whether its transition has not been observed yet.
    pub is_waiting: bool,
    /// Whether an episode has begun that has no action yet.
    pub has_begun: bool,
    /// The last observation, as the environment wrote it.
    pub obs: Vec<f32>,
    /// The episode's costs so far.
    pub costs: Vec<f64>,
}

impl EnvState {
    pub fn new(spec: &EnvSpec, costs: usize, signals: usize) -> Self {
        let taken = Taken {
            obs: vec![0.0; spec.obs_len],
            action: vec![0.0; spec.action_len()],
            log_prob: 0.0,
            values: vec![0.0; signals],
        };
        Self {
            taken,
            is_waiting: false,
            has_begun: false,
            obs: vec![0.0; spec.obs_len],
            costs: vec![0.0; costs],
        }
    }
}

/// Finished episodes and the sums of their costs.
#[derive(Clone, Debug, Default)]
pub(super) struct Fresh {
    pub episodes: u64,
    pub costs: Vec<f64>,
}

impl Fresh {
    pub fn new(costs: usize) -> Self {
        Self { episodes: 0, costs: vec![0.0; costs] }
    }

    pub fn add(&mut self, costs: &[f64]) {
        self.episodes += 1;
        self.costs.iter_mut().zip(costs).for_each(|(sum, cost)| *sum += cost);
    }

    pub fn mean(&self) -> Option<Vec<f64>> {
        let count = self.episodes as f64;
        (self.episodes > 0).then(|| self.costs.iter().map(|sum| sum / count).collect())
    }
}
