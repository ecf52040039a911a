//! What rapier reports in addition to qpos and qvel, body by body, in MuJoCo's terms.

use copq_envs::RobotSpec;
use copq_envs::robot::Inertial;
use rapier3d_f64::prelude::{MultibodyIndex, MultibodyLink, Pose, Vector};

use crate::contact_forces::touches;
use crate::weld::{Weld, inertia};
use crate::world::World;

/// A body of the description on the link that carries it.
struct Rider {
    link: usize,
    /// Its frame in the link's.
    pose: Pose,
    inertial: Inertial,
}

/// The bodies of a description, in order.
pub(crate) struct Fields {
    riders: Vec<Rider>,
    /// The body of each geom; `None` is the world.
    geoms: Vec<Option<usize>>,
}

impl Fields {
    /// `links` holds the link of each body with joints; link 0 is the fixed base, at the origin of
    /// the world.
    pub(crate) fn new(robot: &RobotSpec, welds: &[Weld], links: &[usize]) -> Self {
        let riders = welds.iter().zip(&robot.bodies).map(|(weld, body)| Rider {
            link: weld.carrier.map_or(0, |carrier| links[carrier]),
            pose: weld.pose,
            inertial: body.inertial,
        });
        Self { riders: riders.collect(), geoms: robot.geoms.iter().map(|geom| geom.body).collect() }
    }

    pub(crate) fn positions(&self, view: View<'_>, out: &mut [f64]) {
        self.rows(out, |rider| view.frame(rider).translation.to_array());
    }

    pub(crate) fn centres(&self, view: View<'_>, out: &mut [f64]) {
        self.rows(out, |rider| view.centre(rider).to_array());
    }

    pub(crate) fn inertias(&self, view: View<'_>, out: &mut [f64]) {
        let whole = self.centre_of_mass(view);
        self.rows(out, |rider| {
            let arm = view.centre(rider) - whole;
            let about = inertia(&rider.inertial, view.frame(rider).rotation, arm);
            let [x, y, z] = [about.x_axis, about.y_axis, about.z_axis];
            let mass = rider.inertial.mass;
            [x.x, y.y, z.z, x.y, x.z, y.z, mass * arm.x, mass * arm.y, mass * arm.z, mass]
        });
    }

    pub(crate) fn velocities(&self, view: View<'_>, out: &mut [f64]) {
        let whole = self.centre_of_mass(view);
        self.rows(out, |rider| {
            let (angular, linear) = view.twist(rider, whole);
            [angular.x, angular.y, angular.z, linear.x, linear.y, linear.z]
        });
    }

    /// The forces are those of the last timestep, whose length is `dt`.
    pub(crate) fn contact_forces(&self, view: View<'_>, dt: f64, out: &mut [f64]) {
        out.fill(0.0);
        let whole = self.centre_of_mass(view);
        for touch in touches(view.world, dt) {
            for (geom, force) in touch.geoms.iter().zip([touch.force, -touch.force]) {
                let Some(body) = self.geoms[*geom] else { continue };
                let torque = (touch.point - whole).cross(force);
                let row = torque.to_array().into_iter().chain(force.to_array());
                out[6 * body..6 * body + 6]
                    .iter_mut()
                    .zip(row)
                    .for_each(|(out, value)| *out += value);
            }
        }
    }

    pub(crate) fn centre_of_mass(&self, view: View<'_>) -> Vector {
        let moment = self
            .riders
            .iter()
            .map(|rider| rider.inertial.mass * view.centre(rider))
            .sum::<Vector>();
        moment / self.riders.iter().map(|rider| rider.inertial.mass).sum::<f64>()
    }

    fn rows<const N: usize>(&self, out: &mut [f64], row: impl Fn(&Rider) -> [f64; N]) {
        out.chunks_exact_mut(N)
            .zip(&self.riders)
            .for_each(|(out, rider)| out.copy_from_slice(&row(rider)));
    }
}

/// A robot in its world, as the last step or reset left it.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub world: &'a World,
    pub robot: MultibodyIndex,
}

impl View<'_> {
    fn link(&self, rider: &Rider) -> Option<&MultibodyLink> {
        self.world.multibody(self.robot).link(rider.link)
    }

    /// The frame of a body in the world. Links are never removed, so there always is one.
    fn frame(&self, rider: &Rider) -> Pose {
        self.link(rider).map_or(Pose::IDENTITY, |link| *link.local_to_world()) * rider.pose
    }

    fn centre(&self, rider: &Rider) -> Vector {
        self.frame(rider) * Vector::from_array(rider.inertial.com)
    }

    /// Angular velocity of a body, and linear velocity of its point at `point`, in world axes.
    /// rapier's Jacobian is that of the carrier's centre of mass.
    fn twist(&self, rider: &Rider, point: Vector) -> (Vector, Vector) {
        let multibody = self.world.multibody(self.robot);
        let twist = multibody.body_jacobian(rider.link) * multibody.generalized_velocity();
        let linear = Vector::new(twist[0], twist[1], twist[2]);
        let angular = Vector::new(twist[3], twist[4], twist[5]);
        let body =
            self.link(rider).and_then(|link| self.world.bodies.get(link.rigid_body_handle()));
        let centre = body.map_or(Vector::ZERO, |body| body.center_of_mass());
        (angular, linear + angular.cross(point - centre))
    }
}
