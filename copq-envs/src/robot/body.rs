//! A rigid body: where it is attached and how its mass is distributed.

/// One rigid body of a robot.
///
/// ```
/// use copq_envs::robot::{Body, Capsule};
///
/// // A shin below a knee that is 0.4 m below the hip.
/// let shin = Capsule::between([0.0; 3], [0.0, 0.0, -0.4], 0.04).solid(1000.0);
/// let body = Body::new("shin", Some(0), [0.0, 0.0, -0.4], shin);
/// assert_eq!(body.inertial.com, [0.0, 0.0, -0.2]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// A name that is unique among the bodies and is not `world`; it may be empty.
    pub name: String,
    /// Index of the parent body; `None` is the world.
    pub parent: Option<usize>,
    /// Origin of the frame in the parent's frame (m), with all joints at their reference.
    pub pos: [f64; 3],
    /// Orientation of the frame in the parent's frame (w, x, y, z).
    pub quat: [f64; 4],
    /// Mass and inertia.
    pub inertial: Inertial,
}

impl Body {
    /// A body whose frame is parallel to its parent's.
    pub fn new(name: &str, parent: Option<usize>, pos: [f64; 3], inertial: Inertial) -> Self {
        Self { name: name.into(), parent, pos, quat: [1.0, 0.0, 0.0, 0.0], inertial }
    }
}

/// How a body's mass is distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass in the body frame (m).
    pub com: [f64; 3],
    /// Moments of inertia about the centre of mass along the principal axes (kg m^2).
    pub moments: [f64; 3],
    /// Orientation of the principal axes in the body frame (w, x, y, z).
    pub quat: [f64; 4],
}
