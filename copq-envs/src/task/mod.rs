//! A task: a robot, and the rewards in order of priority.

mod benchmark_a;
mod benchmark_b;
mod gymnasium;
mod listing;
mod options;
mod registry;
mod reward;

pub use listing::list_tasks;
pub use options::Options;
pub use registry::{task, task_with, tasks};
pub use reward::{Motion, Signal, SignalSum};

use copq::EnvSpec;

use crate::{Field, RobotSpec};

/// Everything about an environment except the engine.
///
/// ```
/// use copq_envs::robot::VelocityPoint;
///
/// let mut task = copq_envs::task("a/humanoid")?;
/// task.horizon = 500;
/// task.objectives[1].weight = 2.0;
/// task.robot.velocity_point = VelocityPoint::Body(0); // the torso's velocity, not the centre's
///
/// let spec = task.env_spec();
/// assert_eq!(spec.names(), ["safety", "velocity", "control"]);
/// assert_eq!((spec.weights(), spec.horizon), (vec![1.0, 2.0, 1.0], 500));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// A short name such as `a/hopper`: the benchmark and the robot.
    pub name: String,
    /// The robot.
    pub robot: RobotSpec,
    /// The rewards, highest priority first.
    pub objectives: Vec<SignalSum>,
    /// Steps after which an episode is truncated.
    pub horizon: usize,
}

impl Task {
    /// The fields that an engine must report in addition to qpos and qvel; some may be listed
    /// twice.
    pub fn fields(&self) -> Vec<Field> {
        let signals = self
            .objectives
            .iter()
            .flat_map(|objective| &objective.terms)
            .map(|(_, signal)| *signal);
        let rewards = signals.filter_map(Signal::field);
        self.robot
            .observation
            .fields()
            .chain(self.robot.velocity_point.field())
            .chain(rewards)
            .collect()
    }

    /// The task as learners see it: actions are in [-1, 1].
    pub fn env_spec(&self) -> EnvSpec {
        let obs_len = self.robot.observation.len(&self.robot);
        let spec = EnvSpec::new(&self.name, obs_len, self.robot.nu()).horizon(self.horizon);
        self.objectives.iter().fold(spec, |spec, objective| {
            spec.objective(match objective.limit {
                Some(limit) => {
                    copq::Objective::cost(&objective.name, limit as f32).weight(objective.weight)
                }
                None => copq::Objective::reward(&objective.name, objective.weight),
            })
        })
    }
}
