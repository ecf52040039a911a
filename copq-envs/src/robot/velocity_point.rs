//! Which point counts as a robot's place. The place's change over a step gives the robot's
//! velocity.

use crate::{Field, Readings};

use super::RobotSpec;

/// The point whose x and y are tracked.
///
/// ```
/// use copq_envs::Field;
/// use copq_envs::robot::VelocityPoint;
///
/// // What an engine must report for it, in addition to qpos.
/// assert_eq!(VelocityPoint::X.field(), None);
/// assert_eq!(VelocityPoint::Centre.field(), Some(Field::BodyCentre));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityPoint {
    /// A planar robot's root: x is qpos\[0\], y is always 0.
    X,
    /// A free root: x and y are qpos\[0\] and qpos\[1\].
    Xy,
    /// The origin of this body, from the engine's last evaluation (Gymnasium's ant).
    Body(usize),
    /// The whole robot's centre of mass, from the engine's last evaluation.
    Centre,
}

impl VelocityPoint {
    /// The field it is computed from, if qpos is not enough.
    pub fn field(self) -> Option<Field> {
        match self {
            Self::X | Self::Xy => None,
            Self::Body(_) => Some(Field::BodyPosition),
            Self::Centre => Some(Field::BodyCentre),
        }
    }

    /// x and y (m).
    pub fn place(self, robot: &RobotSpec, qpos: &[f64], readings: &Readings) -> [f64; 2] {
        match self {
            Self::X => [qpos[0], 0.0],
            Self::Xy => [qpos[0], qpos[1]],
            Self::Body(body) => {
                let position = &readings.get(Field::BodyPosition)[3 * body..];
                [position[0], position[1]]
            }
            Self::Centre => {
                let [x, y, _] = centre_of_mass(robot, readings);
                [x, y]
            }
        }
    }
}

/// The whole robot's centre of mass (m), from [`Field::BodyCentre`].
pub(super) fn centre_of_mass(robot: &RobotSpec, readings: &Readings) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (body, centre) in robot.bodies.iter().zip(readings.get(Field::BodyCentre).chunks(3)) {
        sum.iter_mut().zip(centre).for_each(|(sum, centre)| *sum += body.inertial.mass * centre);
    }
    sum.map(|moment| moment / robot.total_mass())
}
