//! The engines that this build has.

use copq_envs::RobotSpec;
use copq_envs_mujoco::Mujoco;

/// Makes an engine for a robot.
pub type Make = fn(&RobotSpec) -> copq::Result<Mujoco>;

pub const ENGINES: &[Make] = &[
    #[cfg(feature = "mujoco-rs")]
    copq_envs_mujoco::mujoco_rs::physics,
    #[cfg(feature = "system")]
    copq_envs_mujoco::system::physics,
];
