//! A task: a robot, and the rewards in order of priority.

mod benchmark_a;
mod benchmark_b;
mod gymnasium;
mod listing;
mod options;
mod registry;
mod reward;

pub use listing::list_tasks;
pub use options::{ControlCost, Cost, FailingStep, Options, Start};
pub use registry::{task, task_with, tasks};
pub use reward::{Motion, Objective, Signal};

use copq::EnvSpec;

use crate::{Field, RobotSpec};

/// Everything about an environment but the engine.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// A short name such as `a/hopper`: the benchmark and the robot.
    pub name: String,
    /// The robot.
    pub robot: RobotSpec,
    /// The rewards, highest priority first.
    pub objectives: Vec<Objective>,
    /// Steps after which an episode is truncated.
    pub horizon: usize,
}

impl Task {
    /// The fields that an engine must tell beside qpos and qvel, some perhaps twice.
    pub fn fields(&self) -> Vec<Field> {
        let signals = self.objectives.iter().flat_map(|objective| &objective.terms).map(|(_, signal)| *signal);
        let rewards = signals.filter_map(Signal::field);
        self.robot.observation.fields().chain(self.robot.track.field()).chain(rewards).collect()
    }

    /// The task as learners see it: actions are in [-1, 1].
    pub fn env_spec(&self) -> EnvSpec {
        let nu = self.robot.nu();
        EnvSpec {
            name: self.name.clone(),
            observation: self.robot.observation.len(&self.robot),
            action_low: vec![-1.0; nu],
            action_high: vec![1.0; nu],
            objectives: self.objectives.iter().map(|objective| objective.name.clone()).collect(),
            weights: self.objectives.iter().map(|objective| objective.weight).collect(),
            limits: self.objectives.iter().map(|objective| objective.limit.map(|limit| limit as f32)).collect(),
            entropy: None, // the last reward's, in every task here
            horizon: self.horizon,
        }
    }
}
