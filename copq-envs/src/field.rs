//! Quantities that an engine may report in addition to qpos and qvel.

use crate::RobotSpec;

/// A quantity of [`Physics::read`](crate::Physics::read), in MuJoCo's units and axes.
///
/// "Bodies" are [`RobotSpec::bodies`] in order, without the world. Arrays are row-major, with one
/// row for each body.
///
/// ```
/// use copq_envs::Field;
///
/// let hopper = copq_envs::task("a/hopper")?.robot; // four bodies, six freedoms
/// assert_eq!(Field::BodyPosition.len(&hopper), 4 * 3);
/// assert_eq!(Field::ContactForce.len(&hopper), 4 * 6);
/// assert_eq!(Field::ActuatorForce.len(&hopper), 6);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Origins of the body frames in world axes (m), bodies x 3. MuJoCo's xpos.
    BodyPosition,
    /// Centres of mass of the bodies in world axes (m), bodies x 3. MuJoCo's xipos.
    BodyCentre,
    /// Inertia in world axes, moved to the robot's centre of mass, bodies x 10: Ixx, Iyy, Izz, Ixy,
    /// Ixz, Iyz (kg m^2), mass times the body's centre relative to the robot's (kg m), mass (kg).
    /// MuJoCo's cinert.
    Inertia,
    /// Angular velocity (rad/s), then linear velocity of the body's point at the robot's centre of
    /// mass (m/s), in world axes, bodies x 6. MuJoCo's cvel.
    Velocity,
    /// Generalised force of the actuators, nv (N or N m). MuJoCo's qfrc_actuator.
    ActuatorForce,
    /// Torque about the robot's centre of mass (N m), then force (N), that contacts exert on each
    /// body, in world axes, bodies x 6. MuJoCo's cfrc_ext.
    ContactForce,
}

impl Field {
    /// How many numbers the field has for this robot.
    pub fn len(self, robot: &RobotSpec) -> usize {
        match self {
            Self::BodyPosition | Self::BodyCentre => 3 * robot.bodies.len(),
            Self::Inertia => 10 * robot.bodies.len(),
            Self::Velocity | Self::ContactForce => 6 * robot.bodies.len(),
            Self::ActuatorForce => robot.nv(),
        }
    }
}
