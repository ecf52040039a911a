//! Joint limits, as soft as MuJoCo's.

use copq_envs::RobotSpec;
use copq_envs::robot::Softness;
use rapier3d_f64::prelude::{JointAxesMask, Multibody, MultibodyJoint};

use crate::coordinate::{Coordinate, Place};
use crate::scalar_joint::Axis;
use crate::soft_constraint::{relaxed, spring};

/// The smallest gap that rapier's solver sees as a violation (rad or m).
const GAP: f64 = 1e-12;

/// A joint with limits.
struct Limit {
    axis: Axis,
    /// Limits of rapier's coordinate.
    range: [f64; 2],
    softness: Softness,
}

/// All joints with limits. A limit that is not violated costs rapier as much as one that is, so
/// rapier gets only the violated ones.
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
            let dof = limit.axis.dof;
            let velocity = multibody.generalized_velocity()[dof];
            let push = multibody.generalized_acceleration()[dof];
            if let Some(link) = multibody.link_mut(limit.axis.link) {
                limit.apply(&mut link.joint, velocity, push * self.dt, self.dt);
            }
        }
    }
}

impl Limit {
    /// `velocity` is the joint's, `push` its change in a timestep without contacts and limits.
    fn apply(&self, joint: &mut MultibodyJoint, velocity: f64, push: f64, dt: f64) {
        let index = self.axis.axis;
        let [low, high] = self.range;
        let coordinate = joint.coords()[index];
        let limits = &mut joint.data.limits[index];
        let axis = JointAxesMask::from_bits_truncate(1 << index);
        let share = if coordinate < low {
            let (share, gap) = self.reaction(coordinate - low, velocity, push, dt);
            (limits.min, limits.max) = (coordinate + gap, f64::MAX);
            share
        } else if coordinate > high {
            let (share, gap) = self.reaction(high - coordinate, -velocity, -push, dt);
            (limits.min, limits.max) = (-f64::MAX, coordinate - gap);
            share
        } else {
            return joint.data.limit_axes.remove(axis);
        };
        joint.data.limit_axes.insert(axis);
        joint.data.softness = spring(share, dt);
    }

    /// Share and gap for a violation (negative), given its rate of change and how that rate would
    /// change without contacts and limits.
    ///
    /// rapier's limits cannot aim at a velocity further into the violation, only at rest. Where
    /// MuJoCo would let the joint continue more slowly, a smaller share removes as much of its
    /// velocity.
    fn reaction(&self, position: f64, velocity: f64, push: f64, dt: f64) -> (f64, f64) {
        let share = self.softness.impedance(position);
        let relaxed = relaxed(&self.softness, share, position, velocity, dt);
        let target = velocity + (relaxed - velocity) / share;
        if target >= 0.0 {
            return (share, target * dt + GAP);
        }
        let free = velocity + push;
        let wanted = relaxed + (1.0 - share) * push;
        let taken = if free < 0.0 { 1.0 - wanted / free } else { share };
        (taken.clamp(1e-4, share), GAP)
    }
}
