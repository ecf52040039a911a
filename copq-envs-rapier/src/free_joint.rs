//! A free root in rapier's multibody: three translations, then three rotations, all in world axes.

use rapier3d_f64::prelude::{Multibody, Rotation, Vector};

use crate::frame::rotation;

/// A free joint: qpos is position and quaternion (w, x, y, z), qvel the linear velocity in world
/// axes and the angular velocity in body axes.
#[derive(Clone, Debug)]
pub(crate) struct Free {
    /// The multibody's link.
    pub link: usize,
    /// Index of the first of its six degrees of freedom in the multibody's velocity vector.
    pub dof: usize,
}

impl Free {
    /// Writes position and quaternion.
    pub(crate) fn position(&self, multibody: &Multibody, qpos: &mut [f64]) {
        // The link is one of this multibody's, and links are never removed.
        let Some(link) = multibody.link(self.link) else { return qpos.fill(f64::NAN) };
        let at = link.joint.coords();
        let turn = link.joint.joint_rot();
        qpos.copy_from_slice(&[at[0], at[1], at[2], turn.w, turn.x, turn.y, turn.z]);
    }

    /// Writes linear and angular velocity from rapier's.
    pub(crate) fn velocity(&self, multibody: &Multibody, freedoms: &[f64], qvel: &mut [f64]) {
        let Some(link) = multibody.link(self.link) else { return qvel.fill(f64::NAN) };
        let spin = link.joint.joint_rot().inverse() * Vector::from_slice(&freedoms[self.dof + 3..]);
        qvel[..3].copy_from_slice(&freedoms[self.dof..self.dof + 3]);
        qvel[3..].copy_from_slice(&spin.to_array());
    }

    /// The inverse of [`Free::position`]: a displacement from the identity.
    pub(crate) fn displacement(&self, qpos: &[f64], out: &mut [f64]) {
        out[self.dof..self.dof + 3].copy_from_slice(&qpos[..3]);
        out[self.dof + 3..self.dof + 6].copy_from_slice(&scaled_axis(orientation(qpos)).to_array());
    }

    /// The inverse of [`Free::velocity`].
    pub(crate) fn freedoms(&self, qpos: &[f64], qvel: &[f64], out: &mut [f64]) {
        let spin = orientation(qpos) * Vector::from_slice(&qvel[3..]);
        out[self.dof..self.dof + 3].copy_from_slice(&qvel[..3]);
        out[self.dof + 3..self.dof + 6].copy_from_slice(&spin.to_array());
    }
}

fn orientation(qpos: &[f64]) -> Rotation {
    rotation([qpos[3], qpos[4], qpos[5], qpos[6]])
}

/// Axis times angle. The angle goes up to a full turn, so that a quaternion keeps its sign.
fn scaled_axis(turn: Rotation) -> Vector {
    let sine = Vector::new(turn.x, turn.y, turn.z);
    let angle = 2.0 * sine.length().atan2(turn.w);
    sine.try_normalize().unwrap_or(Vector::X) * angle
}
