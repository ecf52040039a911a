//! Tests of MuJoCo as an engine; the renderer's are a program of their own, which needs EGL.

#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod allocations;
#[cfg(feature = "mujoco-rs")]
mod brax;
mod doctor;
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod engine;
#[cfg(feature = "mujoco-rs")]
mod golden_mujoco_rs;
#[cfg(feature = "system")]
mod golden_system;
#[cfg(feature = "system")]
mod missing_library;
#[cfg(any(feature = "mujoco-rs", feature = "system"))]
mod support;
