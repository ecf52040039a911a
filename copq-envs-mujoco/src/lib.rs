//! C MuJoCo as a physics engine for copq's robots.
//!
//! There are two engines behind one type, `Mujoco`, because no binding covers all versions of
//! MuJoCo's structs:
//!
//! * feature `mujoco-rs`: module `mujoco_rs`, MuJoCo 3.17.0, bit for bit Gymnasium's v5 robots. Use
//!   it for results to report.
//! * feature `system`: module `system`, the installed MuJoCo, version 2.2.2 (Debian's) or later.
//!
//! Feature `render` adds `Renderer` to the first: pictures of a robot, without a window.
//!
//! Without features the crate builds with nothing installed, and can do nothing. The README
//! explains how to get MuJoCo, and [`doctor`] (`copq doctor` on the command line) reports what is
//! missing.
#![cfg_attr(
    feature = "mujoco-rs",
    doc = r#"
```
let mut env = copq_envs_mujoco::mujoco_rs::make("gym/hopper")?;
let mut obs = vec![0.0; 11];
let mut reward = [0.0];
env.reset(1, &mut obs)?;
env.step(&[0.1, -0.2, 0.3], &mut obs, &mut reward)?;
assert!(reward[0] > 0.9);
# Ok::<(), copq::Error>(())
```
"#
)]
//!
//! An environment is not tied to a thread. Many can run at once, each with its own data.

#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod c_text;
mod doctor;
#[cfg(feature = "mujoco-rs")]
mod guard;
#[cfg(all(test, any(feature = "mujoco-rs", feature = "system")))]
mod guard_tests;
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod physics;
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod simulation;
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod version;

#[cfg(feature = "mujoco-rs")]
pub mod mujoco_rs;
#[cfg(feature = "render")]
mod render;
#[cfg(feature = "system")]
pub mod system;

pub use doctor::{Report, doctor};
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
pub use physics::Mujoco;
#[cfg(feature = "render")]
pub use render::Renderer;
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
pub use version::dotted;
