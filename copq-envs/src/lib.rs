//! Robots, tasks, rewards and the locomotion environment of copq, generic over the physics engine.
//!
//! A [`RobotSpec`] is a robot in plain data; a [`Task`] is a robot with rewards, health and weights; a [`Physics`] is an
//! engine that moves the robot; [`Locomotion`] puts the three together into a [`copq::Env`]. No engine lives here: take
//! `copq-envs-rapier` (pure Rust) or bring your own.
//!
//! ```
//! let task = copq_envs::task("a/hopper")?;
//! assert_eq!(task.robot.nu(), 3);
//! assert_eq!(copq_envs::tasks(), ["a/hopper"]);
//! let error = copq_envs::task("a/hoper").unwrap_err();
//! assert_eq!(error.to_string(), "unknown task 'a/hoper'; known: a/hopper");
//! # Ok::<(), copq::Error>(())
//! ```

mod field;
mod locomotion;
mod physics;
pub mod robot;
pub mod task;

pub use field::Field;
pub use locomotion::Locomotion;
pub use physics::{Dims, Physics};
pub use robot::RobotSpec;
pub use task::{Task, task, tasks};
