//! Benchmark A: MuJoCo robots with a reward vector of safety, velocity and control (paper section
//! 5.1, Table 1).

use super::{Options, Signal, SignalSum};

/// A row of the paper's Table 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// The safety reward of a healthy step; 0 for a robot that has no safety objective.
    pub bonus: f64,
    /// Weights of safety, velocity and control.
    pub weights: [f32; 3],
}

impl Row {
    /// Safety, forward velocity, and minus the squared controls (equation C.1).
    pub(super) fn objectives(&self, options: &Options) -> Vec<SignalSum> {
        let [safety, velocity, control] = self.weights;
        let healthy = options.bonus.unwrap_or(Signal::Healthy);
        let squares = options.control.unwrap_or(Signal::Control);
        let mut objectives = vec![
            SignalSum::new("safety", safety).plus(self.bonus, healthy),
            SignalSum::new("velocity", velocity).plus(1.0, Signal::Velocity),
            SignalSum::new("control", control).plus(-1.0, squares),
        ];
        if self.bonus == 0.0 {
            objectives.remove(0);
        }
        objectives
    }
}
