//! C MuJoCo as a physics engine for copq's robots: **not there yet**.
//!
//! This release reserves the crate and its features, and builds with nothing installed. The engines come in the next
//! release, as two implementations of `copq_envs::Physics`: feature `mujoco-rs` for MuJoCo 3.17, feature `system` for an
//! installed libmujoco (Debian's 2.2.2 among them), and `render` for off-screen pictures. Until then enabling a feature
//! stops the build with a message; use `copq-envs-rapier`, which needs nothing installed.

#[cfg(any(feature = "mujoco-rs", feature = "system", feature = "render"))]
compile_error!("copq-envs-mujoco has no engine in this release; use copq-envs-rapier, or leave its features off");
