//! Builds a rapier world from a robot.

use copq::{Error, Result};
use copq_envs::RobotSpec;
use copq_envs::robot::JointKind;
use rapier3d_f64::prelude::{
    MassProperties, MultibodyIndex, Pose, RigidBody, RigidBodyBuilder, RigidBodyHandle,
};

use crate::collider::{collider, groups};
use crate::coordinate::{Coordinate, coordinates};
use crate::frame::pose;
use crate::link::{Link, Moves, chain};
use crate::weld::{Weld, mass, welds};
use crate::world::World;

/// A robot at its reference pose, never stepped.
pub(crate) struct Assembly {
    pub world: World,
    pub robot: MultibodyIndex,
    /// One for each joint, in the order of qpos and qvel.
    pub coordinates: Vec<Coordinate>,
    /// What each body of the description is welded to.
    pub welds: Vec<Weld>,
    /// The multibody's link of each body with joints; 0, the base, for the others.
    pub links: Vec<usize>,
}

impl Assembly {
    pub(crate) fn new(robot: &RobotSpec) -> Result<Self> {
        robot.check()?;
        check_joints(robot)?;
        let mut builder = Builder::new(robot);
        (0..robot.bodies.len()).try_for_each(|body| builder.add_body(body))?;
        builder.add_colliders()?;
        builder.finish()
    }

    /// Damping and armature of every joint. rapier damps angular degrees of freedom by 0.1 unless
    /// told otherwise.
    fn set_passive(&mut self, robot: &RobotSpec) {
        let (multibody, _) = self.world.split(self.robot);
        for (coordinate, joint) in self.coordinates.iter().zip(&robot.joints) {
            for dof in coordinate.dofs() {
                multibody.damping_mut()[dof] = joint.damping;
                multibody.armature_mut()[dof] = joint.armature;
            }
        }
    }
}

/// A world under construction.
struct Builder<'a> {
    robot: &'a RobotSpec,
    world: World,
    /// The robot is attached to a fixed body; the floor belongs to no body, so that robot and floor
    /// may touch.
    base: RigidBodyHandle,
    welds: Vec<Weld>,
    /// rapier's body for each body with joints; the base for the others.
    bodies: Vec<RigidBodyHandle>,
    /// What each link moves, in the order of the joints, with rapier's body.
    moves: Vec<(Moves, RigidBodyHandle)>,
}

impl<'a> Builder<'a> {
    fn new(robot: &'a RobotSpec) -> Self {
        let mut world = World::empty();
        let base = world.bodies.insert(RigidBodyBuilder::fixed());
        let bodies = vec![base; robot.bodies.len()];
        Self { robot, world, base, welds: welds(robot), bodies, moves: Vec::new() }
    }

    /// A body with joints becomes a chain of links: massless links between its joints, then its own
    /// link at the end.
    fn add_body(&mut self, body: usize) -> Result<()> {
        let spec = &self.robot.bodies[body];
        let parent = spec.parent.map(|parent| self.welds[parent]);
        let frame = parent.map_or(Pose::IDENTITY, |parent| parent.pose) * pose(spec.pos, spec.quat);
        let mut tip = parent
            .and_then(|parent| parent.carrier)
            .map_or(self.base, |carrier| self.bodies[carrier]);
        let joints: Vec<_> = self.robot.joints_of(body).collect();
        let links = chain(&joints, frame);
        let last = links.len().saturating_sub(1);
        for (index, Link { joint, moves }) in links.into_iter().enumerate() {
            let mass = if index == last {
                mass(self.robot, &self.welds, body)
            } else {
                MassProperties::default()
            };
            let next = self.world.bodies.insert(rigid_body(mass));
            if self.world.joints.insert(tip, next, joint, true).is_none() {
                return Err(refused(self.robot, "a tree of bodies", "a loop"));
            }
            self.moves.push((moves, next));
            tip = next;
            self.bodies[body] = next;
        }
        Ok(())
    }

    fn add_colliders(&mut self) -> Result<()> {
        let World { bodies, colliders, .. } = &mut self.world;
        for (index, groups) in groups(self.robot)?.into_iter().enumerate() {
            let weld = self.robot.geoms[index].body.map(|body| self.welds[body]);
            let frame = weld.map_or(Pose::IDENTITY, |weld| weld.pose);
            let collider = collider(self.robot, index, frame, groups);
            match weld.and_then(|weld| weld.carrier) {
                Some(carrier) => {
                    colliders.insert_with_parent(collider, self.bodies[carrier], bodies)
                }
                None => colliders.insert(collider),
            };
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Assembly> {
        let Some(robot) = self.world.joints.rigid_body_link(self.base).map(|link| link.multibody)
        else {
            return Err(refused(self.robot, "at least one joint", "none"));
        };
        settle(robot, &mut self.world);
        let moves = self.moves.iter().map(|(moves, body)| (moves, self.link(*body)));
        let coordinates = coordinates(self.robot, self.world.multibody(robot), moves);
        let links = self.bodies.iter().map(|body| self.link(*body)).collect();
        let mut assembly =
            Assembly { world: self.world, robot, coordinates, welds: self.welds, links };
        assembly.set_passive(self.robot);
        Ok(assembly)
    }

    /// The index of a body's link in the multibody.
    fn link(&self, body: RigidBodyHandle) -> usize {
        // Every body got a link in `add_body`; the base is the first.
        self.world.joints.rigid_body_link(body).map_or(0, |link| link.id)
    }
}

fn rigid_body(mass: MassProperties) -> RigidBody {
    RigidBodyBuilder::dynamic().can_sleep(false).additional_mass_properties(mass).build()
}

/// Gives bodies their masses (rapier itself does so only in the first step), fixes the base (which
/// removes its six degrees of freedom) and puts every body where the joints say.
fn settle(index: MultibodyIndex, world: &mut World) {
    for (_, body) in world.bodies.iter_mut() {
        body.recompute_mass_properties_from_colliders(&world.colliders);
    }
    let (multibody, bodies) = world.split(index);
    multibody.forward_kinematics(bodies, true);
    multibody.update_rigid_bodies(bodies, true);
}

/// Checks that a free joint moves a body without a parent, and is its only joint.
fn check_joints(robot: &RobotSpec) -> Result<()> {
    for joint in &robot.joints {
        let body = &robot.bodies[joint.body];
        let alone = robot.joints_of(joint.body).count() == 1 && body.parent.is_none();
        if joint.kind == JointKind::Free && !alone {
            let got = format!("{} on {}", joint.name, body.name);
            return Err(refused(robot, "a lone free joint on a body without a parent", got));
        }
    }
    Ok(())
}

fn refused(robot: &RobotSpec, wanted: &str, got: impl ToString) -> Error {
    Error::invalid(format!("rapier: joints of {}", robot.name), wanted, got)
}
