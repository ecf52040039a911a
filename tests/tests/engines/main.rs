//! What every physics engine promises, on every engine that this build has: rapier, and MuJoCo with
//! features.

mod engine;
#[cfg(feature = "mujoco-rs")]
mod gymnasium;
mod learning;
mod physics;
mod worlds;
