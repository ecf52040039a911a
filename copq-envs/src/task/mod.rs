//! A task: a robot, what counts as healthy, what is observed, and the rewards in order of priority.

mod benchmark_a;
mod health;
mod observation;
mod registry;
mod reward;

pub use health::Health;
pub use observation::Observation;
pub use registry::{task, tasks};
pub use reward::{Motion, Objective, Signal};

use crate::RobotSpec;

/// Everything about an environment but the engine.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// A short name such as `a/hopper`: the benchmark and the robot.
    pub name: String,
    /// The robot.
    pub robot: RobotSpec,
    /// The rewards, highest priority first.
    pub objectives: Vec<Objective>,
    /// When an episode terminates.
    pub health: Health,
    /// What the agent sees.
    pub observation: Observation,
    /// Steps after which an episode is truncated.
    pub horizon: usize,
}
