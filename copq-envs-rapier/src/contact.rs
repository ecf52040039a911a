//! Contacts, soft and slippery as MuJoCo's.

use copq_envs::RobotSpec;
use copq_envs::robot::Softness;
use rapier3d_f64::prelude::{
    ColliderHandle, ContactModificationContext, Multibody, PhysicsHooks, RigidBodyHandle, RigidBodySet, Vector,
};

use crate::law::relaxed;

/// The A in MuJoCo's R is not the contact's own but a mean over directions, at the body's centre in the reference pose. In
/// random rollouts the contact's own, which rapier takes, is 1.6 (hopper), 1.9 (walker), 2.1 (halfcheetah), 1.0 (ant) and
/// 1.6 (humanoid) times as large (medians).
const TRUE_INVERSE_MASS: f64 = 1.5;

/// What a contact needs to know of a geom.
struct Surface {
    condim: u8,
    softness: Softness,
}

/// How a body moves: its centre of mass, the velocity there, and its angular velocity, in world axes.
#[derive(Clone, Copy, Default)]
struct Twist {
    centre: Vector,
    linear: Vector,
    angular: Vector,
}

impl Twist {
    fn at(&self, point: Vector) -> Vector {
        self.linear + self.angular.cross(point - self.centre)
    }
}

/// Gives rapier's contacts the velocities that MuJoCo's strive for, and takes the friction from those of condim 1.
pub(crate) struct Contacts {
    /// By the user data of rapier's colliders.
    surfaces: Vec<Surface>,
    /// By the index of rapier's bodies.
    twists: Vec<Twist>,
    /// The share that every contact takes, in (0, 1).
    share: f64,
    dt: f64,
}

impl Contacts {
    pub(crate) fn new(robot: &RobotSpec) -> Self {
        let surface = |geom: &copq_envs::robot::Geom| Surface { condim: geom.condim, softness: geom.softness };
        let surfaces = robot.geoms.iter().map(surface).collect();
        Self { surfaces, twists: Vec::new(), share: share(robot), dt: robot.timestep }
    }

    /// The share that every contact takes: rapier has one softness for the whole world.
    pub(crate) fn share(&self) -> f64 {
        self.share
    }

    /// Takes note of the velocities before a timestep. rapier's own for a multibody's links are one step old by then.
    pub(crate) fn watch(&mut self, multibody: &Multibody, bodies: &RigidBodySet) {
        let velocity = multibody.generalized_velocity();
        for (index, link) in multibody.links().enumerate() {
            let (id, _) = link.rigid_body_handle().into_raw_parts();
            let twist = multibody.body_jacobian(index) * velocity;
            let centre = bodies.get(link.rigid_body_handle()).map_or(Vector::ZERO, |body| body.center_of_mass());
            let (linear, angular) = (Vector::new(twist[0], twist[1], twist[2]), Vector::new(twist[3], twist[4], twist[5]));
            if self.twists.len() <= id as usize {
                self.twists.resize(id as usize + 1, Twist::default());
            }
            self.twists[id as usize] = Twist { centre, linear, angular };
        }
    }

    /// The velocity of a body's point; bodies not watched stand still.
    fn velocity(&self, body: Option<RigidBodyHandle>, point: Vector) -> Vector {
        let twist = body.and_then(|body| self.twists.get(body.into_raw_parts().0 as usize));
        twist.map_or(Vector::ZERO, |twist| twist.at(point))
    }

    fn surface(&self, context: &ContactModificationContext<'_>, collider: ColliderHandle) -> Option<&Surface> {
        self.surfaces.get(context.colliders.get(collider)?.user_data as usize)
    }
}

impl PhysicsHooks for Contacts {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let surfaces = [context.collider1, context.collider2].map(|collider| self.surface(context, collider));
        let [Some(first), Some(second)] = surfaces else { return };
        let bodies = [context.rigid_body1, context.rigid_body2];
        let Some(manifold) = context.rigid_mut() else { return };
        if first.condim == 1 && second.condim == 1 {
            *manifold.friction = 0.0;
        }
        let (softness, friction, normal) = (first.softness.mean(&second.softness), *manifold.friction, *manifold.normal);
        for contact in manifold.solver_contacts.iter_mut() {
            let middle = (contact.anchor1 + contact.anchor2) * 0.5;
            let [one, two] = bodies.map(|body| self.velocity(body, middle));
            let target = self.target(&softness, friction, contact.dist, (two - one).dot(normal));
            // Both anchors in one place, so that the point where friction acts does not move with the gap.
            contact.dist = -target * self.dt;
            contact.anchor1 = middle + normal * (0.5 * contact.dist);
            contact.anchor2 = contact.anchor1;
        }
    }
}

impl Contacts {
    /// The velocity that a contact strives for, whose own share may be another than that of all.
    fn target(&self, softness: &Softness, friction: f64, distance: f64, velocity: f64) -> f64 {
        let share = own_share(softness.impedance(distance), friction);
        velocity + (relaxed(softness, share, distance, velocity, self.dt) - velocity) / self.share
    }
}

/// The share of the robot's roughest geom on the floor, a foot as a rule, when it is pressed in.
fn share(robot: &RobotSpec) -> f64 {
    let floors = robot.geoms.iter().filter(|geom| geom.body.is_none());
    let pairs = floors.flat_map(|floor| {
        let limbs = robot.geoms.iter().filter(|geom| geom.body.is_some());
        limbs.map(|limb| (floor.softness.mean(&limb.softness), floor.friction[0].max(limb.friction[0])))
    });
    let (softness, friction) = pairs.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Softness::MUJOCO, 1.0));
    own_share(softness.impedance(1.0), friction)
}

/// The share of a contact with this impedance d.
///
/// MuJoCo makes a contact of four constraints on the edges of the friction pyramid, with mu the friction. They have
/// `R = 2 mu^2 (1 + mu^2) A (1 - d) / d` each; against the normal, all four together have a quarter of that.
fn own_share(impedance: f64, friction: f64) -> f64 {
    let square = friction * friction;
    let edges = if friction > 0.0 { 0.5 * square * (1.0 + square) } else { 1.0 };
    let strength = TRUE_INVERSE_MASS * impedance / (1.0 - impedance) / edges;
    (strength / (1.0 + strength)).min(0.9999)
}
