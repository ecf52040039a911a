//! Positions and quaternions of a [`RobotSpec`](copq_envs::RobotSpec) as rapier's poses.

use rapier3d_f64::prelude::{Pose, Rotation, Vector};

/// A rotation from (w, x, y, z), normalised.
pub(crate) fn rotation([w, x, y, z]: [f64; 4]) -> Rotation {
    Rotation::from_xyzw(x, y, z, w).normalize()
}

/// A pose from a position and (w, x, y, z).
pub(crate) fn pose(pos: [f64; 3], quat: [f64; 4]) -> Pose {
    Pose::from_parts(Vector::from_array(pos), rotation(quat))
}
