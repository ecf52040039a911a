//! Rewards as sums of a few signals, so that a task is data and not code.

/// A quantity of one environment step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// 1 if the robot is healthy after the step, else 0.
    Healthy,
    /// Signed forward velocity (m/s): the change of x over the step divided by its length.
    Velocity,
    /// Sum of the squared actions, each clamped to [-1, 1].
    Control,
}

/// One component of the reward vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    /// Its name, such as `safety`.
    pub name: String,
    /// Its weight in the task's total return (paper Table 1), not normalised.
    pub weight: f32,
    /// The reward is the sum of factor x signal.
    pub terms: Vec<(f64, Signal)>,
}

/// The values of all signals in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Whether the robot is healthy after the step.
    pub healthy: bool,
    /// Forward velocity (m/s).
    pub velocity: f64,
    /// Sum of the squared, clamped actions.
    pub control: f64,
}

impl Objective {
    /// An objective of one term.
    pub fn new(name: &str, weight: f32, factor: f64, signal: Signal) -> Self {
        Self { name: name.into(), weight, terms: vec![(factor, signal)] }
    }

    /// The reward for a step, unweighted.
    pub fn reward(&self, motion: &Motion) -> f64 {
        self.terms.iter().map(|(factor, signal)| factor * motion.value(*signal)).sum()
    }
}

impl Motion {
    fn value(&self, signal: Signal) -> f64 {
        match signal {
            Signal::Healthy => f64::from(u8::from(self.healthy)),
            Signal::Velocity => self.velocity,
            Signal::Control => self.control,
        }
    }
}
