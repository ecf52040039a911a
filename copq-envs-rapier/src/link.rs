//! The joints of one body as one rapier joint with several free axes.

use copq::{Error, Result};
use copq_envs::RobotSpec;
use copq_envs::robot::{Joint, JointKind};
use rapier3d_f64::prelude::{GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis, Pose, Rotation, Vector};

use crate::frame::pose;
use crate::softness::spring;

/// One link: a rapier joint, and for each of the body's joints its index and rapier's axis (0..3 linear, 3..6 angular).
pub(crate) struct Link {
    pub joint: GenericJoint,
    pub axes: Vec<(usize, usize)>,
}

/// A half turn about an axis, or none: what it takes to point axes along the frame's positive ones.
///
/// Frames stay aligned with the body's own. Rotating hinges onto x, as rapier's revolute joint does, puts rounding noise
/// into directions that a planar robot cannot move in, and all ground friction is lost to it.
const TURNS: [[f64; 4]; 4] = [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

const AXES: [(JointAxis, JointAxesMask); 6] = [
    (JointAxis::LinX, JointAxesMask::LIN_X),
    (JointAxis::LinY, JointAxesMask::LIN_Y),
    (JointAxis::LinZ, JointAxesMask::LIN_Z),
    (JointAxis::AngX, JointAxesMask::ANG_X),
    (JointAxis::AngY, JointAxesMask::ANG_Y),
    (JointAxis::AngZ, JointAxesMask::ANG_Z),
];

impl Link {
    /// The link that moves a body: slides along different axes, then at most one hinge, all axis-aligned.
    pub(crate) fn new(robot: &RobotSpec, body: usize) -> Result<Self> {
        let joints: Vec<_> = robot.joints_of(body).collect();
        let (turn, axes) = TURNS
            .iter()
            .find_map(|turn| align(&joints, Rotation::from_array(*turn)))
            .ok_or_else(|| unsupported(robot, body))?;
        if !in_order(&axes) {
            return Err(unsupported(robot, body));
        }
        let mut joint = free_joint(robot, body, &joints, turn, &axes);
        for ((_, spec), (_, axis)) in joints.iter().zip(&axes) {
            limit(&mut joint, spec, AXES[*axis].0);
        }
        Ok(Self { joint, axes })
    }
}

/// The axis of each joint in a frame turned this way, if every one is a positive axis of it.
fn align(joints: &[(usize, &Joint)], turn: Rotation) -> Option<(Rotation, Vec<(usize, usize)>)> {
    let axes = joints.iter().map(|(index, joint)| Some((*index, axis(joint, turn)?))).collect::<Option<Vec<_>>>()?;
    (!axes.is_empty()).then_some((turn, axes))
}

fn axis(joint: &Joint, turn: Rotation) -> Option<usize> {
    let first = match joint.kind {
        JointKind::Slide => 0,
        JointKind::Hinge => 3,
        JointKind::Free => return None,
    };
    let axis = turn.inverse() * Vector::from_array(joint.axis);
    let along = [Vector::X, Vector::Y, Vector::Z].iter().position(|unit| axis == *unit)?;
    Some(first + along)
}

/// Each axis once, at most one of them angular, and it last: rapier translates in the parent's frame, then rotates.
fn in_order(axes: &[(usize, usize)]) -> bool {
    axes.windows(2).all(|pair| pair[0].1 < pair[1].1 && pair[0].1 < 3)
}

fn free_joint(
    robot: &RobotSpec,
    body: usize,
    joints: &[(usize, &Joint)],
    turn: Rotation,
    axes: &[(usize, usize)],
) -> GenericJoint {
    let free = axes.iter().fold(JointAxesMask::empty(), |mask, (_, axis)| mask | AXES[*axis].1);
    // Only a hinge's anchor matters; `in_order` leaves it last, and `align` leaves no empty list.
    let anchor = joints.last().map_or([0.0; 3], |(_, joint)| joint.anchor);
    let child = Pose::from_parts(Vector::from_array(anchor), turn);
    let spec = &robot.bodies[body];
    GenericJointBuilder::new(free.complement())
        .local_frame1(pose(spec.pos, spec.quat) * child)
        .local_frame2(child)
        .contacts_enabled(false)
        .build()
}

fn limit(joint: &mut GenericJoint, spec: &Joint, axis: JointAxis) {
    if let Some([low, high]) = spec.range {
        joint.set_limits(axis, [low - spec.reference, high - spec.reference]);
        joint.softness = spring(&spec.softness);
    }
}

fn unsupported(robot: &RobotSpec, body: usize) -> Error {
    Error::invalid(
        format!("rapier: joints of {}'s {}", robot.name, robot.bodies[body].name),
        "slides along x, y, z in order, then at most one hinge, all axis-aligned (more comes with more robots)",
        format!("{:?}", robot.joints_of(body).map(|(_, joint)| (joint.kind, joint.axis)).collect::<Vec<_>>()),
    )
}
