//! Geoms as rapier's colliders.

use copq::{Error, Result};
use copq_envs::RobotSpec;
use copq_envs::robot::{Geom, Shape};
use rapier3d_f64::prelude::{
    ActiveHooks, CoefficientCombineRule, Collider, ColliderBuilder, Group, InteractionGroups, InteractionTestMode,
    SharedShape, Vector,
};

use crate::frame::pose;

/// rapier's collision groups have this many bits.
const GROUPS: usize = 32;

/// The collider of one geom. It has no mass of its own: bodies carry theirs.
pub(crate) fn collider(robot: &RobotSpec, index: usize) -> Result<Collider> {
    if robot.geoms.len() > GROUPS {
        return Err(Error::invalid(format!("rapier: geoms of {}", robot.name), "at most 32", robot.geoms.len()));
    }
    let geom = &robot.geoms[index];
    let collider = ColliderBuilder::new(shape(geom))
        .position(pose(geom.pos, geom.quat))
        .density(0.0)
        .friction(geom.friction[0])
        .friction_combine_rule(CoefficientCombineRule::Max)
        .contact_skin(geom.margin)
        .collision_groups(groups(robot, index))
        .user_data(index as u128)
        .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
    Ok(collider.build())
}

fn shape(geom: &Geom) -> SharedShape {
    match geom.shape {
        Shape::Plane => SharedShape::halfspace(Vector::Z),
        Shape::Capsule { radius, half_length } => SharedShape::capsule_z(half_length, radius),
        Shape::Sphere { radius } => SharedShape::ball(radius),
    }
}

/// A bit for each geom, and the bits of the geoms it may touch: MuJoCo's rule, pair by pair.
fn groups(robot: &RobotSpec, index: usize) -> InteractionGroups {
    let partners = (0..robot.geoms.len()).filter(|&other| robot.collide(index, other));
    let filter = partners.fold(0, |bits, other| bits | (1 << other));
    let own = Group::from_bits_truncate(1 << index);
    InteractionGroups::new(own, Group::from_bits_truncate(filter), InteractionTestMode::And)
}
