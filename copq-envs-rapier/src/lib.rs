//! rapier as a physics engine for copq's robots: pure Rust, nothing to install.
//!
//! ```
//! use copq::Outcome;
//!
//! let mut env = copq_envs_rapier::make("a/hopper")?;
//! let mut obs = vec![0.0; env.spec().obs_len];
//! let mut reward = vec![0.0; env.spec().objectives.len()];
//! env.reset(1, &mut obs)?;
//! let outcome = env.step(&[0.1, -0.2, 0.3], &mut obs, &mut reward)?;
//! assert_eq!(outcome, Outcome::Running);
//! assert_eq!(env.spec().names(), ["safety", "velocity", "control"]);
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! Masses and joint-space inertia are MuJoCo's. Contacts and joint limits follow its law of soft
//! constraints as far as rapier's solver can. Random policies fall as soon as they do on MuJoCo,
//! within 10 %. The exception is the ant, whose falls depend on the timestep: Brax's ant lasts 64
//! to 72 steps here and 44 on MuJoCo, but 83 to 95 on both with timesteps of half the length or
//! less. Returns are not comparable number for number. A physics world belongs to one environment,
//! which any thread may step, one at a time.

mod assemble;
mod collider;
mod contact;
mod contact_forces;
mod coordinate;
mod fields;
mod frame;
mod free_joint;
mod friction;
mod limits;
mod link;
mod motors;
mod physics;
mod pipeline;
mod scalar_joint;
mod soft_constraint;
mod twist;
mod weld;
mod world;

pub use physics::Rapier;

use copq::{Env, Result};
use copq_envs::{Locomotion, Options};

/// The environment of this name (see [`copq_envs::tasks`]) on rapier. The error for an unknown name
/// lists the nearest ones.
pub fn make(name: &str) -> Result<Box<dyn Env>> {
    make_with(name, &Options::default())
}

/// The environment of this name with these options.
pub fn make_with(name: &str, options: &Options) -> Result<Box<dyn Env>> {
    Ok(Box::new(Locomotion::make(name, options, Rapier::new)?))
}
