//! The joints of one body as a chain of rapier joints.

use copq_envs::robot::{Joint, JointKind};
use rapier3d_f64::prelude::{
    GenericJoint, GenericJointBuilder, JointAxesMask, Pose, Rotation, Vector,
};

use crate::frame::{aligned, tilted};

/// One rapier joint.
pub(crate) struct Link {
    pub joint: GenericJoint,
    pub moves: Moves,
}

/// What a link moves.
pub(crate) enum Moves {
    /// All six degrees of freedom of a free joint.
    Free,
    /// Slides and at most one hinge, each as a joint's index and rapier's axis (0..3 linear, 3..6
    /// angular).
    Axes(Vec<(usize, usize)>),
}

type Joints<'a> = [(usize, &'a Joint)];

/// The links that move a body from its parent, in order: as few as rapier needs.
///
/// `frame` is the body's frame in its parent's, with all joints at their reference. Links after the
/// first start from there.
pub(crate) fn chain(joints: &Joints<'_>, frame: Pose) -> Vec<Link> {
    let mut links = Vec::new();
    let mut rest = joints;
    let mut frame = frame;
    while !rest.is_empty() {
        let (link, used) = longest(rest, frame);
        links.push(link);
        (rest, frame) = (&rest[used..], Pose::IDENTITY);
    }
    links
}

/// A link for as many of these joints as possible, and how many.
fn longest(joints: &Joints<'_>, frame: Pose) -> (Link, usize) {
    let (first, joint) = joints[0];
    match joint.kind {
        JointKind::Free => (free(), 1),
        JointKind::Slide | JointKind::Hinge => (1..=joints.len())
            .rev()
            .find_map(|count| Some((together(&joints[..count], frame)?, count)))
            .unwrap_or_else(|| (single(first, joint, frame), 1)),
    }
}

/// qpos gives a free body's pose in the world, whatever its place in the description.
fn free() -> Link {
    let data = GenericJointBuilder::new(JointAxesMask::empty()).contacts_enabled(false).build();
    Link { joint: data, moves: Moves::Free }
}

/// One link for slides along different axes, then at most one hinge, all axis-aligned and at most
/// one of them limited: rapier translates in the parent's frame and then rotates, panics at two
/// angles, and has one softness for a link's limits.
fn together(joints: &Joints<'_>, frame: Pose) -> Option<Link> {
    if joints.iter().any(|(_, joint)| joint.kind == JointKind::Free) {
        return None;
    }
    let directions: Vec<_> = joints.iter().map(|(_, joint)| joint.axis).collect();
    let (turn, axes) = aligned(&directions)?;
    let axes: Vec<_> =
        joints.iter().zip(axes).map(|((_, joint), axis)| first_axis(joint) + axis).collect();
    let in_order = axes.windows(2).all(|pair| pair[0] < pair[1] && pair[0] < 3);
    let limited = joints.iter().filter(|(_, joint)| joint.range.is_some()).count();
    (in_order && limited <= 1).then(|| link(joints, &axes, frame, turn))
}

/// A link for one slide or hinge along any axis.
fn single(index: usize, joint: &Joint, frame: Pose) -> Link {
    link(&[(index, joint)], &[first_axis(joint)], frame, tilted(joint.axis))
}

fn first_axis(joint: &Joint) -> usize {
    if joint.kind == JointKind::Slide { 0 } else { 3 }
}

fn link(joints: &Joints<'_>, axes: &[usize], frame: Pose, turn: Rotation) -> Link {
    let open = axes.iter().fold(JointAxesMask::empty(), |mask, axis| {
        mask | JointAxesMask::from_bits_truncate(1 << axis)
    });
    // Only a hinge's anchor matters, and it comes last.
    let anchor = joints.last().map_or([0.0; 3], |(_, joint)| joint.anchor);
    let child = Pose::from_parts(Vector::from_array(anchor), turn);
    let joint = GenericJointBuilder::new(open.complement())
        .local_frame1(frame * child)
        .local_frame2(child)
        .contacts_enabled(false)
        .build();
    let indices = joints.iter().map(|(index, _)| *index);
    Link { joint, moves: Moves::Axes(indices.zip(axes.iter().copied()).collect()) }
}
