//! Contacts, as soft and slippery as MuJoCo's.

use copq_envs::RobotSpec;
use copq_envs::robot::{Geom, Softness};
use rapier3d_f64::prelude::{
    ColliderHandle, ContactModificationContext, Multibody, PhysicsHooks, RigidBodySet, Vector,
};

use crate::friction::{gain, stuck_share};
use crate::twist::Twists;

/// What a contact needs to know about a geom.
struct Surface {
    condim: u8,
    softness: Softness,
}

/// Gives rapier's contacts the target velocities of MuJoCo's, and removes friction from those of
/// condim 1.
pub(crate) struct Contacts {
    /// Indexed by the user data of rapier's colliders.
    surfaces: Vec<Surface>,
    twists: Twists,
    share: f64,
    dt: f64,
}

impl Contacts {
    pub(crate) fn new(robot: &RobotSpec) -> Self {
        let surface = |geom: &Geom| Surface { condim: geom.condim, softness: geom.softness };
        let surfaces = robot.geoms.iter().map(surface).collect();
        Self { surfaces, twists: Twists::default(), share: common_share(robot), dt: robot.timestep }
    }

    /// The share that every contact takes: rapier has one softness for the whole world.
    pub(crate) fn share(&self) -> f64 {
        self.share
    }

    /// Records the velocities before a timestep.
    pub(crate) fn watch(&mut self, multibody: &Multibody, bodies: &RigidBodySet) {
        self.twists.watch(multibody, bodies);
    }

    fn surface(
        &self,
        context: &ContactModificationContext<'_>,
        collider: ColliderHandle,
    ) -> Option<&Surface> {
        self.surfaces.get(context.colliders.get(collider)?.user_data as usize)
    }
}

impl PhysicsHooks for Contacts {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let surfaces =
            [context.collider1, context.collider2].map(|collider| self.surface(context, collider));
        let [Some(first), Some(second)] = surfaces else { return };
        let bodies = [context.rigid_body1, context.rigid_body2];
        let Some(manifold) = context.rigid_mut() else { return };
        if first.condim == 1 && second.condim == 1 {
            *manifold.friction = 0.0;
        }
        let (softness, friction, normal) =
            (first.softness.mean(&second.softness), *manifold.friction, *manifold.normal);
        for contact in manifold.solver_contacts.iter_mut() {
            let middle = (contact.anchor1 + contact.anchor2) * 0.5;
            let [one, two] = bodies.map(|body| self.twists.at(body, middle));
            let speeds = split(two - one, normal);
            // If a contact's own share differs from the common one, it still gains what it would by
            // itself.
            let target =
                speeds[0] + gain(&softness, friction, contact.dist, speeds, self.dt) / self.share;
            contact.dist = -target * self.dt;
            // Both anchors are in one place, so that the point where friction acts does not move
            // with the gap.
            contact.anchor1 = middle + normal * (0.5 * contact.dist);
            contact.anchor2 = contact.anchor1;
        }
    }
}

/// Speeds along a normal and across it.
fn split(velocity: Vector, normal: Vector) -> [f64; 2] {
    let apart = velocity.dot(normal);
    [apart, (velocity - normal * apart).length()]
}

/// The share of the roughest geom that may touch the floor (usually a foot) when it is pressed in.
fn common_share(robot: &RobotSpec) -> f64 {
    let geoms = || robot.geoms.iter().enumerate();
    let floors = geoms().filter(|(_, geom)| geom.body.is_none());
    let pairs = floors.flat_map(|(floor, below)| {
        let limbs = geoms().filter(move |&(limb, _)| robot.collide(floor, limb));
        limbs.map(|(_, limb)| (below.softness.mean(&limb.softness), friction(below, limb)))
    });
    let (softness, friction) =
        pairs.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Softness::MUJOCO, 1.0));
    stuck_share(softness.impedance(1.0), friction)
}

fn friction(a: &Geom, b: &Geom) -> f64 {
    if a.condim == 1 && b.condim == 1 { 0.0 } else { a.friction[0].max(b.friction[0]) }
}
