//! Parts of observations that are more than positions and velocities.

use nalgebra::Vector3;

use crate::{Field, Readings};

use super::RobotSpec;
use super::velocity_point::centre_of_mass;

/// One part of an [`Observation`](super::Observation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A field as the engine reports it.
    Field {
        /// The field.
        field: Field,
        /// How many of its leading numbers are left out.
        skip: usize,
        /// The rest is clipped to [-clip, clip]; infinite for no clipping.
        clip: f64,
    },
    /// Brax: each body's inertia matrix about the robot's centre of mass in world axes (9,
    /// row-major, kg m^2), then its mass (kg).
    LinkInertia,
    /// Brax: the velocity of each body's centre of mass times its share of the robot's mass (3,
    /// m/s), then its angular velocity (3, rad/s), in world axes.
    LinkVelocity,
}

impl Part {
    /// A whole field, unclipped.
    pub fn field(field: Field) -> Self {
        Self::Field { field, skip: 0, clip: f64::INFINITY }
    }

    /// The fields that it is made of.
    pub fn fields(&self) -> &[Field] {
        match self {
            Self::Field { field, .. } => std::slice::from_ref(field),
            Self::LinkInertia => &[Field::Inertia],
            Self::LinkVelocity => &[Field::Velocity, Field::BodyCentre],
        }
    }

    /// How many numbers it has for this robot.
    pub fn len(&self, robot: &RobotSpec) -> usize {
        match self {
            Self::Field { field, skip, .. } => field.len(robot) - skip,
            Self::LinkInertia => 10 * robot.bodies.len(),
            Self::LinkVelocity => 6 * robot.bodies.len(),
        }
    }

    /// Writes it ([`Part::len`] numbers).
    pub fn write(&self, robot: &RobotSpec, readings: &Readings, out: &mut [f32]) {
        match *self {
            Self::Field { field, skip, clip } => {
                let values =
                    readings.get(field)[skip..].iter().map(|value| value.clamp(-clip, clip));
                out.iter_mut().zip(values).for_each(|(out, value)| *out = value as f32);
            }
            Self::LinkInertia => {
                for (out, inertia) in
                    out.chunks_mut(10).zip(readings.get(Field::Inertia).chunks(10))
                {
                    let [xx, yy, zz, xy, xz, yz] = [0, 1, 2, 3, 4, 5].map(|i| inertia[i] as f32);
                    out.copy_from_slice(&[xx, xy, xz, xy, yy, yz, xz, yz, zz, inertia[9] as f32]);
                }
            }
            Self::LinkVelocity => link_velocity(robot, readings, out),
        }
    }
}

fn link_velocity(robot: &RobotSpec, readings: &Readings, out: &mut [f32]) {
    let middle = centre_of_mass(robot, readings);
    let total = robot.total_mass();
    let centres = readings.get(Field::BodyCentre);
    let velocities = readings.get(Field::Velocity);
    for (index, body) in robot.bodies.iter().enumerate() {
        let arm = [0, 1, 2].map(|i| centres[3 * index + i] - middle[i]);
        let spin = [0, 1, 2].map(|i| velocities[6 * index + i]);
        let swing = Vector3::from(spin).cross(&Vector3::from(arm));
        let share = body.inertial.mass / total;
        for i in 0..3 {
            out[6 * index + i] = (share * (velocities[6 * index + 3 + i] + swing[i])) as f32;
            out[6 * index + 3 + i] = spin[i] as f32;
        }
    }
}
