//! The choices that a task leaves open.

use std::str::FromStr;

use copq::{Error, Result};

use super::Signal;
use crate::robot::{Preset, Senses};

/// Choices that the benchmarks leave open, or in which Gymnasium and Brax differ. The default is
/// what this crate recommends.
///
/// A [`Task`](super::Task) is plain data, so anything that is not here can be changed there:
/// `robot.velocity_point` (the humanoid's velocity is that of its centre of mass;
/// `VelocityPoint::Body(0)` makes it the torso's), `robot.reset_noise`, `robot.health`, `horizon`.
///
/// ```
/// use copq_envs::robot::Preset;
/// use copq_envs::task::Signal;
/// use copq_envs::{Options, task_with};
///
/// let options = Options { preset: Preset::Paper, limit: Some(1414.9), ..Options::default() };
/// let task = task_with("b/humanoid", &options)?;
/// assert_eq!(task.objectives[0].limit, Some(1414.9));
/// assert_eq!(task.robot.observation.len(&task.robot), 244);
///
/// let options = Options { cost: Some(Signal::ForwardSpeed), ..Options::default() };
/// assert_eq!(task_with("b/ant", &options)?.objectives[0].terms, [(1.0, Signal::ForwardSpeed)]);
///
/// // Gymnasium's ant, but on ankles that are within their limits.
/// let ant = |start| task_with("a/ant", &Options { start, ..Options::default() });
/// assert_ne!(ant(None)?.robot.initial_qpos, ant(Some(Preset::Paper))?.robot.initial_qpos);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Which version of the robots.
    pub preset: Preset,
    /// How much the agent sees.
    pub senses: Senses,
    /// The preset whose pose an episode starts from, before noise, instead of the pose of `preset`.
    /// Gymnasium starts the ant with its ankles outside their limits; [`Preset::Paper`] does not.
    pub start: Option<Preset>,
    /// What earns the safety bonus, instead of [`Signal::Healthy`] (the paper, Gymnasium v5).
    /// [`Signal::Alive`] also earns it on the step that ends unhealthy (Brax, Gymnasium v4,
    /// Safety-Gymnasium).
    pub bonus: Option<Signal>,
    /// What the control cost sums, instead of the actions ([`Signal::Control`]) in benchmark A
    /// (paper equation C.1) and the controls ([`Signal::MotorControl`]) in benchmark B and in
    /// Gymnasium's own reward. The two differ only for the humanoid, whose controls are 0.4 times
    /// its actions.
    pub control: Option<Signal>,
    /// Benchmark B's cost of a step, instead of [`Signal::Speed`] (CAL). [`Signal::Velocity`]
    /// (Safety-Gymnasium's code for planar robots) is negative while a robot walks backwards, so
    /// [`check_env`](copq::check_env) rejects it as a cost.
    pub cost: Option<Signal>,
    /// The limit of the episode's cost, instead of benchmark B's own. The paper prints 1411.9 for
    /// the humanoid, probably a misprint of 1414.9: a thousand times Safety-Gymnasium's threshold,
    /// as for the other robots.
    pub limit: Option<f64>,
}

impl FromStr for Preset {
    type Err = Error;

    /// From `gym-v5` or `paper`.
    fn from_str(name: &str) -> Result<Self> {
        match name {
            "gym-v5" => Ok(Self::GymV5),
            "paper" => Ok(Self::Paper),
            _ => Err(Error::unknown("preset", name, &["gym-v5", "paper"])),
        }
    }
}
