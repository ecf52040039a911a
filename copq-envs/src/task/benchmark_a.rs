//! Benchmark A: Gymnasium's robots with a reward vector of safety, velocity and control (paper section 5.1, Table 1).

use super::{Health, Objective, Observation, Signal, Task};
use crate::robot;

/// The hopper: safety 1 while healthy, forward velocity, -sum of squared actions; weights (1, 1, 1).
pub(super) fn hopper() -> Task {
    Task {
        name: "a/hopper".into(),
        robot: robot::hopper(),
        objectives: safety_velocity_control(1.0, [1.0, 1.0, 1.0]),
        health: Health::Planar { height: [0.7, f64::INFINITY], pitch: [-0.2, 0.2], bound: 100.0 },
        observation: Observation { skip: 1, clip: 10.0 },
        horizon: 1000,
    }
}

fn safety_velocity_control(bonus: f64, weights: [f32; 3]) -> Vec<Objective> {
    vec![
        Objective::new("safety", weights[0], bonus, Signal::Healthy),
        Objective::new("velocity", weights[1], 1.0, Signal::Velocity),
        Objective::new("control", weights[2], -1.0, Signal::Control),
    ]
}
