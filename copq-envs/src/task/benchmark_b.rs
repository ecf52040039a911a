//! Benchmark B: go forward, but not too fast (the velocity tasks of Safety-Gymnasium in Brax's
//! form; paper appendix C).

use super::{Options, Signal, SignalSum};

/// A row of the paper's Table C.1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// What being healthy, a forward velocity of 1 m/s and a sum of squared controls of 1
    /// contribute to the reward.
    pub weights: [f64; 3],
    /// The limit that an episode's cost must not exceed.
    pub limit: f64,
}

impl Row {
    /// The cost, which comes first, and a scalar reward.
    pub(super) fn objectives(&self, options: &Options) -> Vec<SignalSum> {
        let speed = options.cost.unwrap_or(Signal::Speed);
        let limit = options.limit.unwrap_or(self.limit);
        let cost = SignalSum::new("cost", 0.0).plus(1.0, speed).limit(limit);
        vec![cost, scalar(self.weights, options)]
    }
}

/// A reward for health and velocity, minus control, with these factors.
pub(super) fn scalar([healthy, velocity, control]: [f64; 3], options: &Options) -> SignalSum {
    let bonus = options.bonus.unwrap_or(Signal::Healthy);
    let squares = options.control.unwrap_or(Signal::MotorControl);
    SignalSum::new("reward", 1.0)
        .plus(healthy, bonus)
        .plus(velocity, Signal::Velocity)
        .plus(-control, squares)
}
