//! Where a joint's coordinate and its motor live in rapier's multibody.

use rapier3d_f64::prelude::{Multibody, Real};

/// The stiffness of the spring that stands for a motor on a joint without one (N m/rad), a power of two.
///
/// rapier has no generalised force. A spring pulled far away gives the same torque: it adds only k dt^2 of inertia and
/// k dt of damping, here below 1e-8, while the rounding error of the torque does not depend on k.
const MOTOR_STIFFNESS: f64 = 1.0 / (1024.0 * 1024.0);

/// One scalar joint: an entry of qpos and of qvel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coordinate {
    /// The multibody's link.
    pub link: usize,
    /// rapier's axis within the link, 0..6.
    pub axis: usize,
    /// Index in the multibody's velocity vector.
    pub dof: usize,
    /// qpos where rapier's coordinate is 0.
    pub reference: f64,
    /// The joint's own spring (N m/rad).
    pub stiffness: f64,
}

impl Coordinate {
    /// The joint's value in qpos.
    pub(crate) fn position(&self, multibody: &Multibody) -> Real {
        // A coordinate is made from a link of this multibody, and links are never removed.
        multibody.link(self.link).map_or(Real::NAN, |link| link.joint.coords()[self.axis]) + self.reference
    }

    /// Applies a generalised force (N or N m) from now on; together with the joint's own spring, if it has one.
    pub(crate) fn drive(&self, multibody: &mut Multibody, force: Real) {
        let Some(link) = multibody.link_mut(self.link) else { return };
        let (stiffness, rest) = if self.stiffness > 0.0 {
            (self.stiffness, force / self.stiffness)
        } else {
            (MOTOR_STIFFNESS, link.joint.coords()[self.axis] + force / MOTOR_STIFFNESS)
        };
        link.joint.set_spring(self.axis, stiffness, rest);
    }
}
