//! Gymnasium v5's own scalar rewards, to compare with what others report.

use super::{Objective, Options, Signal, benchmark_b};

/// A robot's reward.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// What being healthy, a forward velocity of 1 m/s and a sum of squared controls of 1
    /// contribute.
    pub weights: [f64; 3],
    /// Minus what contact forces cost: a factor, and their [`Signal::Contact`].
    pub contact: Option<(f64, Signal)>,
}

impl Row {
    /// One reward. Brax has the same but for contact forces, which it does not price.
    pub(super) fn objectives(&self, options: &Options) -> Vec<Objective> {
        vec![benchmark_b::scalar(self.weights, self.contact.as_slice(), options)]
    }
}
