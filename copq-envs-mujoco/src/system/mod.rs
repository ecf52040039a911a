//! An installed MuJoCo, any version from 2.2.2 on, opened at run time.

mod library;
mod shim;
mod simulation;

use copq::{Env, Result};
use copq_envs::{Locomotion, Options, RobotSpec};

use crate::Mujoco;

/// The environment of this name (see [`copq_envs::tasks`]). The error for an unknown name lists the
/// nearest ones.
pub fn make(name: &str) -> Result<Box<dyn Env>> {
    make_with(name, &Options::default())
}

/// The environment of this name with these options.
pub fn make_with(name: &str, options: &Options) -> Result<Box<dyn Env>> {
    Ok(Box::new(Locomotion::make(name, options, physics)?))
}

/// The engine with this robot in it.
pub fn physics(robot: &RobotSpec) -> Result<Mujoco> {
    Mujoco::new(robot, version()?, simulation::open)
}

/// The version of the library that was found, as `mj_version` counts; an error says what is
/// missing.
///
/// The library is the file that `COPQ_MUJOCO_LIBRARY` names, or else the one beside the headers of
/// the build, or else what the loader finds. It must have the version of the headers.
pub fn version() -> Result<i32> {
    library::library().map(|shim| shim.header)
}

/// The version of the headers that were there at build time, as `mj_version` counts; `None` if
/// there were none.
pub fn header() -> Option<i32> {
    library::header()
}
