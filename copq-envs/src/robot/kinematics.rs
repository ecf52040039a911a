//! Forward kinematics: where a robot's bodies and shapes are, computed from qpos alone, without an
//! engine.

use super::{Geom, Joint, JointKind, Pose, RobotSpec, Shape};

/// A capsule in the world: all points within `radius` of the line between its ends. It is a ball if
/// they coincide.
///
/// ```
/// use copq_envs::robot::{Preset, hopper};
///
/// // The hopper at its start, as it is drawn: torso, thigh, leg and foot of one limb.
/// let hopper = hopper(Preset::GymV5);
/// let segments = hopper.segments(&hopper.body_poses(&hopper.initial_qpos));
/// assert!(segments.len() == 4 && segments.iter().all(|segment| segment.limb == 0));
/// let [top, _] = segments[0].ends;
/// assert!((top[2] - 1.45).abs() < 1e-12 && segments[0].radius == 0.05);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Which limb it is part of. The bodies from one branching to the next count as one limb; limbs
    /// are numbered in the order of the bodies.
    pub limb: usize,
    /// Centres of the two caps, in world axes (m).
    pub ends: [[f64; 3]; 2],
    /// Radius (m).
    pub radius: f64,
}

impl RobotSpec {
    /// The poses of the bodies, in their order: MuJoCo's xpos and xquat. Panics if `qpos` has fewer
    /// than nq entries.
    pub fn body_poses(&self, qpos: &[f64]) -> Vec<Pose> {
        let mut poses = Vec::<Pose>::with_capacity(self.bodies.len());
        let mut rest = qpos;
        for (index, body) in self.bodies.iter().enumerate() {
            // Bodies come depth first, so a parent's pose is already known.
            let parent = body.parent.map_or(Pose::WORLD, |parent| poses[parent]);
            let mut pose = parent.at(body.pos, body.quat);
            for (_, joint) in self.joints_of(index) {
                let (value, later) = rest.split_at(joint.kind.nq());
                (pose, rest) = (moved(pose, joint, value), later);
            }
            poses.push(pose);
        }
        poses
    }

    /// The pose of a geom, given [`RobotSpec::body_poses`]: MuJoCo's geom_xpos and geom_xmat.
    pub fn geom_pose(&self, geom: &Geom, bodies: &[Pose]) -> Pose {
        geom.body.map_or(Pose::WORLD, |body| bodies[body]).at(geom.pos, geom.quat)
    }

    /// The whole robot's centre of mass in world axes (m), given [`RobotSpec::body_poses`].
    pub fn centre_of_mass(&self, bodies: &[Pose]) -> [f64; 3] {
        let mut moment = [0.0; 3];
        for (body, pose) in self.bodies.iter().zip(bodies) {
            let centre = pose.point(body.inertial.com);
            moment.iter_mut().zip(centre).for_each(|(sum, x)| *sum += body.inertial.mass * x);
        }
        moment.map(|sum| sum / self.total_mass())
    }

    /// The robot's capsules and balls, given [`RobotSpec::body_poses`]: all that is needed to draw
    /// it.
    pub fn segments(&self, bodies: &[Pose]) -> Vec<Segment> {
        let limbs = self.limbs();
        let segment = |geom: &Geom| {
            let (radius, half_length) = match geom.shape {
                Shape::Plane => return None,
                Shape::Capsule { radius, half_length } => (radius, half_length),
                Shape::Sphere { radius } => (radius, 0.0),
            };
            let pose = self.geom_pose(geom, bodies);
            let ends = [half_length, -half_length].map(|z| pose.point([0.0, 0.0, z]));
            Some(Segment { limb: limbs[geom.body?], ends, radius })
        };
        self.geoms.iter().filter_map(segment).collect()
    }

    /// The limb of each body, numbered as in [`Segment::limb`]: an only child continues its
    /// parent's limb.
    pub fn limbs(&self) -> Vec<usize> {
        let children =
            |parent| self.bodies.iter().filter(|body| body.parent == Some(parent)).count();
        let mut limbs = Vec::<usize>::with_capacity(self.bodies.len());
        let mut next = 0..;
        for body in &self.bodies {
            let inherited =
                body.parent.filter(|&parent| children(parent) == 1).map(|parent| limbs[parent]);
            limbs.extend(inherited.or_else(|| next.next()));
        }
        limbs
    }
}

/// A body's pose after one more of its joints has been applied.
fn moved(pose: Pose, joint: &Joint, value: &[f64]) -> Pose {
    match joint.kind {
        JointKind::Free => {
            Pose::WORLD.at([0, 1, 2].map(|i| value[i]), [3, 4, 5, 6].map(|i| value[i]))
        }
        JointKind::Slide => pose.slid(joint.axis, value[0] - joint.reference),
        JointKind::Hinge => pose.rotated(joint.axis, value[0] - joint.reference, joint.anchor),
    }
}
