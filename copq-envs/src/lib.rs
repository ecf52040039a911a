//! Robots, tasks, rewards and the locomotion environment of copq, generic over the physics engine.
//!
//! A [`RobotSpec`] describes a robot as plain data. A [`Task`] is a robot with rewards and weights.
//! A [`Physics`] is an engine that moves the robot. [`Locomotion`] puts the three together into a
//! [`copq::Env`]. This crate has no engine: use `copq-envs-rapier` (pure Rust) or bring your own.
//!
//! ```
//! let task = copq_envs::task("a/hopper")?;
//! assert_eq!(task.robot.nu(), 3);
//! let error = copq_envs::task("a/hoper").unwrap_err();
//! assert!(error.to_string().starts_with("unknown task 'a/hoper'; known: a/hopper, b/hopper"));
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! There are five robots, each in [Gymnasium's or Brax's version](robot::Preset), and three sets of
//! tasks: benchmark A of the COP-Q paper (`a/hopper`: a vector of safety, velocity and control),
//! benchmark B (`b/hopper`: a reward and a cost with a limit), and Gymnasium's own scalar rewards
//! (`gym/hopper`). [`Options`] holds the choices:
//!
//! ```
//! use copq_envs::robot::{Preset, Senses};
//! use copq_envs::{Options, list_tasks, task_with};
//!
//! let options = Options { preset: Preset::Paper, senses: Senses::Joints, ..Options::default() };
//! let task = task_with("b/humanoid", &options)?;
//! assert_eq!(task.robot.observation.len(&task.robot), 45);
//! assert_eq!(task.objectives[0].limit, Some(1411.9));
//! print!("{}", list_tasks(&options)?);
//! # Ok::<(), copq::Error>(())
//! ```

mod field;
mod identity;
mod locomotion;
mod physics;
mod readings;
pub mod robot;
pub mod task;

pub use field::Field;
pub use identity::Identity;
pub use locomotion::Locomotion;
pub use physics::{Dims, Physics};
pub use readings::Readings;
pub use robot::RobotSpec;
pub use task::{Options, Task, list_tasks, task, task_with, tasks};
