//! Limits of joints, soft as MuJoCo's.

use copq_envs::RobotSpec;
use copq_envs::robot::Softness;
use rapier3d_f64::prelude::{JointAxesMask, Multibody, MultibodyJoint};

use crate::axis::Axis;
use crate::coordinate::{Coordinate, Place};
use crate::law::{spring, target};

/// The smallest gap that rapier's solver sees as a violation (rad or m).
const GAP: f64 = 1e-12;

/// A joint with limits.
struct Limit {
    axis: Axis,
    /// Limits of rapier's coordinate.
    range: [f64; 2],
    softness: Softness,
}

/// All joints with limits. A limit that is not violated costs rapier as much as one that is, so it gets those that are.
pub(crate) struct Limits {
    limits: Vec<Limit>,
    dt: f64,
}

impl Limits {
    pub(crate) fn new(robot: &RobotSpec, coordinates: &[Coordinate]) -> Self {
        let limits = robot.joints.iter().zip(coordinates).filter_map(|(spec, coordinate)| {
            let Place::Axis(axis) = &coordinate.joint else { return None };
            let range = spec.range?.map(|limit| limit - spec.reference);
            Some(Limit { axis: axis.clone(), range, softness: spec.softness })
        });
        Self { limits: limits.collect(), dt: robot.timestep }
    }

    /// Tells rapier the limits of the next timestep.
    pub(crate) fn apply(&self, multibody: &mut Multibody) {
        for limit in &self.limits {
            let velocity = multibody.generalized_velocity()[limit.axis.dof];
            if let Some(link) = multibody.link_mut(limit.axis.link) {
                limit.apply(&mut link.joint, velocity, self.dt);
            }
        }
    }
}

impl Limit {
    fn apply(&self, joint: &mut MultibodyJoint, velocity: f64, dt: f64) {
        let (index, [low, high]) = (self.axis.axis, self.range);
        let coordinate = joint.coords()[index];
        let limits = &mut joint.data.limits[index];
        let softer;
        if coordinate < low {
            let (share, gap) = self.reaction(coordinate - low, velocity, dt);
            (limits.min, limits.max, softer) = (coordinate + gap, f64::MAX, share);
        } else if coordinate > high {
            let (share, gap) = self.reaction(high - coordinate, -velocity, dt);
            (limits.min, limits.max, softer) = (-f64::MAX, coordinate - gap, share);
        } else {
            joint.data.limit_axes.remove(JointAxesMask::from_bits_truncate(1 << index));
            return;
        }
        joint.data.limit_axes.insert(JointAxesMask::from_bits_truncate(1 << index));
        joint.data.softness = spring(softer, dt);
    }

    /// Share and gap for a violation (negative) and its rate of change.
    ///
    /// rapier's limits cannot strive for a velocity further into the violation, only for rest. Where MuJoCo would let the
    /// joint go on, more slowly, a smaller share takes as much of its velocity.
    fn reaction(&self, position: f64, velocity: f64, dt: f64) -> (f64, f64) {
        let share = self.softness.impedance(position);
        let target = target(&self.softness, position, velocity, dt);
        if target >= 0.0 { (share, target * dt + GAP) } else { (share * (1.0 - target / velocity), GAP) }
    }
}
