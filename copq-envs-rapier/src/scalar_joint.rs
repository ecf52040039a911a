//! A slide or a hinge in rapier's multibody, with its spring and motor.

use rapier3d_f64::prelude::Multibody;

/// The stiffness of the spring that stands in for a generalised force (N m/rad), a power of two.
///
/// rapier has no generalised force. A spring stretched very far gives the same torque: it adds only
/// k dt^2 of inertia and k dt of damping, here below 1e-8, while the rounding error of the torque
/// does not depend on k.
const MOTOR_STIFFNESS: f64 = 1.0 / (1024.0 * 1024.0);

/// One scalar joint: an entry of qpos and of qvel.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
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

impl Axis {
    /// The joint's value in qpos.
    pub(crate) fn position(&self, multibody: &Multibody) -> f64 {
        // An axis is made from a link of this multibody, and links are never removed.
        multibody.link(self.link).map_or(f64::NAN, |link| link.joint.coords()[self.axis])
            + self.reference
    }

    /// Applies a generalised force (N or N m) and the joint's own spring in the next timestep.
    pub(crate) fn drive(&self, multibody: &mut Multibody, force: f64) {
        let Some(link) = multibody.link_mut(self.link) else { return };
        let coordinate = link.joint.coords()[self.axis];
        let force = force - self.stiffness * coordinate;
        link.joint.set_spring(self.axis, MOTOR_STIFFNESS, coordinate + force / MOTOR_STIFFNESS);
    }
}
