//! Builds a rapier world from a robot.

use copq::{Error, Result};
use copq_envs::RobotSpec;
use copq_envs::robot::{Body, Joint};
use rapier3d_f64::prelude::{MassProperties, MultibodyIndex, RigidBody, RigidBodyBuilder, RigidBodyHandle, Vector};

use crate::collider::collider;
use crate::coordinate::Coordinate;
use crate::frame::rotation;
use crate::link::Link;
use crate::world::World;

/// A robot at its reference pose, never stepped.
pub(crate) struct Assembly {
    pub world: World,
    pub robot: MultibodyIndex,
    /// One for each joint, in the order of qpos and qvel.
    pub coordinates: Vec<Coordinate>,
    /// The rigid bodies, in the order of the description.
    pub bodies: Vec<RigidBodyHandle>,
}

impl Assembly {
    pub(crate) fn new(robot: &RobotSpec) -> Result<Self> {
        robot.check()?;
        let mut world = World::empty();
        // The robot hangs from a fixed body; the floor belongs to none, so that robot and floor may touch.
        let base = world.bodies.insert(RigidBodyBuilder::fixed());
        let bodies: Vec<_> = robot.bodies.iter().map(|body| world.bodies.insert(rigid_body(body))).collect();
        add_colliders(robot, &bodies, &mut world)?;
        let axes = add_joints(robot, base, &bodies, &mut world)?;
        let index = multibody(robot, base, &world)?;
        settle(index, &mut world);
        let coordinates = axes.iter().map(|axis| coordinate(robot, &world, &bodies, *axis)).collect();
        let mut assembly = Self { world, robot: index, coordinates, bodies };
        assembly.set_passive(robot);
        Ok(assembly)
    }

    /// Damping, armature and springs of every joint. rapier damps angular freedoms by 0.1 unless told otherwise.
    fn set_passive(&mut self, robot: &RobotSpec) {
        let (multibody, _) = self.world.split(self.robot);
        for (coordinate, joint) in self.coordinates.iter().zip(&robot.joints) {
            multibody.damping_mut()[coordinate.dof] = joint.damping;
            multibody.armature_mut()[coordinate.dof] = joint.armature;
            if joint.stiffness > 0.0 {
                coordinate.drive(multibody, 0.0);
            }
        }
    }
}

fn rigid_body(body: &Body) -> RigidBody {
    let inertial = &body.inertial;
    let mass = MassProperties::with_principal_inertia_frame(
        Vector::from_array(inertial.com),
        inertial.mass,
        Vector::from_array(inertial.moments),
        rotation(inertial.quat),
    );
    RigidBodyBuilder::dynamic().can_sleep(false).additional_mass_properties(mass).build()
}

fn add_colliders(robot: &RobotSpec, bodies: &[RigidBodyHandle], world: &mut World) -> Result<()> {
    for (index, geom) in robot.geoms.iter().enumerate() {
        let collider = collider(robot, index)?;
        match geom.body {
            Some(body) => world.colliders.insert_with_parent(collider, bodies[body], &mut world.bodies),
            None => world.colliders.insert(collider),
        };
    }
    Ok(())
}

/// Where a joint went: its index, its body and rapier's axis.
#[derive(Clone, Copy)]
struct Axis {
    joint: usize,
    body: usize,
    axis: usize,
}

fn add_joints(
    robot: &RobotSpec,
    base: RigidBodyHandle,
    bodies: &[RigidBodyHandle],
    world: &mut World,
) -> Result<Vec<Axis>> {
    let mut axes = Vec::with_capacity(robot.joints.len());
    for (body, spec) in robot.bodies.iter().enumerate() {
        let link = Link::new(robot, body)?;
        let parent = spec.parent.map_or(base, |parent| bodies[parent]);
        if world.joints.insert(parent, bodies[body], link.joint, true).is_none() {
            return Err(refused(robot, "a tree of bodies"));
        }
        axes.extend(link.axes.iter().map(|&(joint, axis)| Axis { joint, body, axis }));
    }
    Ok(axes)
}

fn multibody(robot: &RobotSpec, base: RigidBodyHandle, world: &World) -> Result<MultibodyIndex> {
    let link = world.joints.rigid_body_link(base).ok_or_else(|| refused(robot, "at least one body"))?;
    Ok(link.multibody)
}

/// Gives bodies their masses (rapier does so in the first step only), fixes the base (which removes its six freedoms) and
/// puts every body where the joints say.
fn settle(index: MultibodyIndex, world: &mut World) {
    for (_, body) in world.bodies.iter_mut() {
        body.recompute_mass_properties_from_colliders(&world.colliders);
    }
    let (multibody, bodies) = world.split(index);
    multibody.forward_kinematics(bodies, true);
    multibody.update_rigid_bodies(bodies, true);
}

fn coordinate(robot: &RobotSpec, world: &World, bodies: &[RigidBodyHandle], at: Axis) -> Coordinate {
    let Joint { reference, stiffness, .. } = robot.joints[at.joint];
    // Every body got a link in `add_joints`.
    let id = world.joints.rigid_body_link(bodies[at.body]).map_or((0, 0), |link| {
        let multibody = &world.joints[link.multibody];
        (link.id, multibody.link(link.id).map_or(0, |link| first_dof(link, at.axis)))
    });
    Coordinate { link: id.0, axis: at.axis, dof: id.1, reference, stiffness }
}

/// The place of an axis among a link's free ones, counted from the link's first.
fn first_dof(link: &rapier3d_f64::prelude::MultibodyLink, axis: usize) -> usize {
    let locked = link.joint.data.locked_axes.bits();
    link.assembly_id() + (0..axis).filter(|before| (locked >> before) & 1 == 0).count()
}

fn refused(robot: &RobotSpec, wanted: &str) -> Error {
    Error::invalid(format!("rapier: bodies of {}", robot.name), wanted, "something else")
}
