//! How the links move before a timestep. The velocities that rapier keeps for a multibody's bodies
//! are one step old by then.

use rapier3d_f64::prelude::{Multibody, RigidBodyHandle, RigidBodySet, Vector};

/// How a body moves: its centre of mass, the velocity there, and its angular velocity, in world
/// axes.
#[derive(Clone, Copy, Default)]
struct Twist {
    centre: Vector,
    linear: Vector,
    angular: Vector,
}

/// The twists of a multibody's bodies, indexed as rapier indexes them.
#[derive(Default)]
pub(crate) struct Twists {
    twists: Vec<Twist>,
}

impl Twists {
    /// Records how the multibody moves now.
    pub(crate) fn watch(&mut self, multibody: &Multibody, bodies: &RigidBodySet) {
        self.twists.resize(bodies.len(), Twist::default());
        let velocity = multibody.generalized_velocity();
        for (index, link) in multibody.links().enumerate() {
            let handle = link.rigid_body_handle();
            let twist = multibody.body_jacobian(index) * velocity;
            let centre = bodies.get(handle).map_or(Vector::ZERO, |body| body.center_of_mass());
            let linear = Vector::new(twist[0], twist[1], twist[2]);
            let angular = Vector::new(twist[3], twist[4], twist[5]);
            // Bodies are never removed, so their indices are below their number.
            self.twists[handle.into_raw_parts().0 as usize] = Twist { centre, linear, angular };
        }
    }

    /// The velocity of a body's point, in world axes; the world stands still.
    pub(crate) fn at(&self, body: Option<RigidBodyHandle>, point: Vector) -> Vector {
        let twist = body.and_then(|body| self.twists.get(body.into_raw_parts().0 as usize));
        twist.map_or(Vector::ZERO, |twist| twist.linear + twist.angular.cross(point - twist.centre))
    }
}
