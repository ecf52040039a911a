//! Gymnasium v5's own scalar rewards, for comparison with results that others report.

use super::{Options, Signal, SignalSum, benchmark_b};
use crate::robot::Preset;

/// A robot's reward.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// What being healthy, a forward velocity of 1 m/s and a sum of squared controls of 1
    /// contribute.
    pub weights: [f64; 3],
    /// The penalty for contact forces: a negative factor and their [`Signal::Contact`].
    pub contact: Option<(f64, Signal)>,
}

impl Row {
    /// One reward. Brax's is the same except for contact forces, which it does not penalise.
    pub(super) fn objectives(&self, options: &Options) -> Vec<SignalSum> {
        let reward = benchmark_b::scalar(self.weights, options);
        let is_gymnasiums = options.preset == Preset::GymV5;
        vec![match self.contact.filter(|_| is_gymnasiums) {
            Some((factor, force)) => reward.plus(factor, force),
            None => reward,
        }]
    }
}
