//! Geoms as rapier's colliders.

use copq::{Error, Result};
use copq_envs::RobotSpec;
use copq_envs::robot::Shape;
use rapier3d_f64::prelude::{
    ActiveHooks, CoefficientCombineRule, Collider, ColliderBuilder, Group, InteractionGroups,
    InteractionTestMode, Pose, SharedShape, Vector,
};

use crate::frame::pose;

/// rapier's collision groups have this many bits.
const GROUPS: usize = 32;

/// The collider of one geom, on a body or in the world at `frame`. It has no mass of its own:
/// bodies carry theirs.
pub(crate) fn collider(
    robot: &RobotSpec,
    index: usize,
    frame: Pose,
    groups: InteractionGroups,
) -> Collider {
    let geom = &robot.geoms[index];
    let shape = match geom.shape {
        Shape::Plane => SharedShape::halfspace(Vector::Z),
        Shape::Capsule { radius, half_length } => SharedShape::capsule_z(half_length, radius),
        Shape::Sphere { radius } => SharedShape::ball(radius),
    };
    ColliderBuilder::new(shape)
        .position(frame * pose(geom.pos, geom.quat))
        .density(0.0)
        .friction(geom.friction[0])
        .friction_combine_rule(CoefficientCombineRule::Max)
        .contact_skin(geom.margin)
        .collision_groups(groups)
        .user_data(index as u128)
        .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
        .build()
}

/// For each geom, which geoms it may touch: MuJoCo's rule, pair by pair. Geoms that may touch the
/// same ones share a bit.
pub(crate) fn groups(robot: &RobotSpec) -> Result<Vec<InteractionGroups>> {
    let geoms = 0..robot.geoms.len();
    let partners = |geom: usize| geoms.clone().map(move |other| robot.collide(geom, other));
    let mut kinds: Vec<usize> = Vec::new();
    let mut kind = |geom: usize| {
        kinds.iter().position(|&known| partners(known).eq(partners(geom))).unwrap_or_else(|| {
            kinds.push(geom);
            kinds.len() - 1
        })
    };
    let bits: Vec<usize> = geoms.clone().map(&mut kind).collect();
    if kinds.len() > GROUPS {
        let wanted = "at most 32 kinds of geom that differ in what they touch";
        return Err(Error::invalid(
            format!("rapier: geoms of {}", robot.name),
            wanted,
            kinds.len(),
        ));
    }
    let group = |bits: u32| Group::from_bits_truncate(bits);
    let filter = |geom| {
        partners(geom)
            .zip(&bits)
            .filter(|(touch, _)| *touch)
            .fold(0, |mask, (_, bit)| mask | 1 << bit)
    };
    let both = geoms.clone().map(|geom| (group(1 << bits[geom]), group(filter(geom))));
    Ok(both
        .map(|(own, filter)| InteractionGroups::new(own, filter, InteractionTestMode::And))
        .collect())
}

#[cfg(test)]
mod tests {
    use copq_envs::robot::{self, Preset};

    use super::*;

    #[test]
    fn the_same_pairs_may_touch() {
        for robot in
            [robot::hopper, robot::walker2d, robot::halfcheetah, robot::ant, robot::humanoid]
        {
            for robot in [robot(Preset::GymV5), robot(Preset::Paper)] {
                let groups = groups(&robot).unwrap();
                for (a, one) in groups.iter().enumerate() {
                    for (b, two) in groups.iter().enumerate() {
                        assert_eq!(one.test(*two), robot.collide(a, b), "{} {a} {b}", robot.name);
                    }
                }
            }
        }
    }
}
