//! What a task leaves to choose.

use std::str::FromStr;

use copq::{Error, Result};

use crate::robot::{Preset, Senses};

/// Choices where the benchmarks leave room or Gymnasium and Brax differ. The default is what this
/// crate recommends.
///
/// A [`Task`](super::Task) is plain data, so what is not here can be changed there:
/// `robot.velocity_point` (the humanoid's velocity is its centre of mass's;
/// `VelocityPoint::Body(0)` makes it the torso's), `robot.reset_noise`, `robot.health`, `horizon`.
///
/// ```
/// use copq_envs::{Options, task_with};
///
/// let options = Options { preset: "paper".parse()?, limit: Some(1414.9), ..Options::default() };
/// let task = task_with("b/humanoid", &options)?;
/// assert_eq!(task.objectives[0].limit, Some(1414.9));
/// assert_eq!(task.robot.observation.len(&task.robot), 244);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Whose robots.
    pub preset: Preset,
    /// How much the agent sees.
    pub senses: Senses,
    /// Where an episode starts.
    pub start: Start,
    /// What the safety bonus of the step that ends unhealthy is.
    pub failing_step: FailingStep,
    /// Which controls the control cost squares.
    pub control: ControlCost,
    /// What benchmark B's cost is.
    pub cost: Cost,
    /// Instead of benchmark B's own limit of the episode's cost. The paper prints 1411.9 for the
    /// humanoid, probably for 1414.9, a thousand times Safety-Gymnasium's threshold as for the
    /// other robots.
    pub limit: Option<f64>,
}

/// The pose at the start of an episode, before noise.
///
/// ```
/// use copq_envs::task::{Options, Start, task_with};
///
/// // Gymnasium's ant, but on ankles that are within their limits.
/// let ant = |start| task_with("a/ant", &Options { start, ..Options::default() });
/// assert_ne!(ant(Start::Preset)?.robot.initial_qpos, ant(Start::Paper)?.robot.initial_qpos);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Start {
    /// The preset's own.
    #[default]
    Preset,
    /// That of [`Preset::Paper`], on the robot of any preset: it differs for the ant, which
    /// Gymnasium starts with its ankles outside their limits.
    Paper,
}

/// What the step that ends unhealthy earns for safety.
///
/// ```
/// use copq_envs::task::{FailingStep, Options, Signal, task_with};
///
/// let options = Options { failing_step: FailingStep::Bonus, ..Options::default() };
/// assert_eq!(task_with("a/hopper", &options)?.objectives[0].terms, [(1.0, Signal::Alive)]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FailingStep {
    /// Nothing (the paper, Gymnasium v5).
    #[default]
    Nothing,
    /// The bonus (Brax, Gymnasium v4, Safety-Gymnasium).
    Bonus,
}

/// What the control cost sums the squares of. They differ for the humanoid only, whose controls are
/// 0.4 times its actions.
///
/// ```
/// use copq_envs::task::{ControlCost, Options, Signal, task_with};
///
/// let options = Options { control: ControlCost::Motors, ..Options::default() };
/// let task = task_with("a/humanoid", &options)?;
/// assert_eq!(task.objectives[2].terms, [(-1.0, Signal::MotorControl)]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ControlCost {
    /// Actions in benchmark A (paper equation C.1), controls in benchmark B and in Gymnasium's own
    /// reward.
    #[default]
    Benchmark,
    /// The actions in [-1, 1].
    Actions,
    /// The motors' controls.
    Motors,
}

/// Benchmark B's cost of a step.
///
/// ```
/// use copq_envs::task::{Cost, Options, Signal, task_with};
///
/// let options = Options { cost: Cost::ForwardSpeed, ..Options::default() };
/// assert_eq!(task_with("b/ant", &options)?.objectives[0].terms, [(1.0, Signal::ForwardSpeed)]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cost {
    /// The speed in the x-y plane, of a planar robot the size of its forward velocity (CAL).
    #[default]
    Speed,
    /// The size of the forward velocity.
    ForwardSpeed,
    /// The signed forward velocity (Safety-Gymnasium's code for planar robots): negative, and so no
    /// cost that [`check_env`](copq::check_env) lets pass, while a robot walks backwards.
    Velocity,
}

impl FromStr for Preset {
    type Err = Error;

    /// From `gym-v5` or `paper`.
    fn from_str(name: &str) -> Result<Self> {
        choose("preset", name, &[("gym-v5", Self::GymV5), ("paper", Self::Paper)])
    }
}

impl FromStr for Senses {
    type Err = Error;

    /// From `standard`, `joints` or `gymnasium`.
    fn from_str(name: &str) -> Result<Self> {
        choose(
            "senses",
            name,
            &[
                ("standard", Self::Standard),
                ("joints", Self::Joints),
                ("gymnasium", Self::Gymnasium),
            ],
        )
    }
}

fn choose<T: Copy>(kind: &'static str, name: &str, known: &[(&str, T)]) -> Result<T> {
    let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
    let found = known.iter().find(|(known, _)| *known == name);
    found.map(|(_, value)| *value).ok_or_else(|| Error::unknown(kind, name, &names))
}
