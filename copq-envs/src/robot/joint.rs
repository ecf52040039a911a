//! A joint: which way a body may move relative to its parent.

use super::Softness;

/// The degrees of freedom that a joint gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// All six degrees of freedom; qpos holds position and quaternion (7), qvel the linear velocity
    /// in world axes and the angular velocity in body axes (6).
    Free,
    /// Translation along the axis (m).
    Slide,
    /// Rotation about the axis (rad).
    Hinge,
}

impl JointKind {
    /// Entries in qpos.
    pub fn nq(self) -> usize {
        if self == Self::Free { 7 } else { 1 }
    }

    /// Entries in qvel.
    pub fn nv(self) -> usize {
        if self == Self::Free { 6 } else { 1 }
    }
}

/// One joint of a robot.
///
/// ```
/// use copq_envs::robot::Joint;
///
/// let knee = Joint::hinge("knee", 1, [0.0, 1.0, 0.0]);
/// let knee = Joint { range: Some([-2.0, 0.0]), damping: 0.1, ..knee };
/// assert_eq!((knee.kind.nq(), knee.kind.nv()), (1, 1));
/// let root = Joint::free("root", 0);
/// assert_eq!((root.kind.nq(), root.kind.nv()), (7, 6));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// A name that is unique among the joints; it may be empty if the joint has no motor.
    pub name: String,
    /// Index of the body that it moves.
    pub body: usize,
    /// The degrees of freedom that it gives.
    pub kind: JointKind,
    /// Axis in the body frame, of any length except 0 (it has no meaning for a free joint).
    pub axis: [f64; 3],
    /// Point on the axis in the body frame (m).
    pub anchor: [f64; 3],
    /// The value of qpos at which the body has the pose of its [`Body`](super::Body) entry; springs
    /// rest there.
    pub reference: f64,
    /// Limits of qpos, if any.
    pub range: Option<[f64; 2]>,
    /// Viscous damping (N s/m or N m s/rad).
    pub damping: f64,
    /// Inertia of the rotor, added to the mass matrix's diagonal (kg or kg m^2).
    pub armature: f64,
    /// Spring stiffness towards the reference (N/m or N m/rad).
    pub stiffness: f64,
    /// How soft the limits are.
    pub softness: Softness,
}

impl Joint {
    /// All six degrees of freedom.
    pub fn free(name: &str, body: usize) -> Self {
        Self::new(name, body, JointKind::Free, [0.0, 0.0, 1.0])
    }

    /// A translation along an axis.
    pub fn slide(name: &str, body: usize, axis: [f64; 3]) -> Self {
        Self::new(name, body, JointKind::Slide, axis)
    }

    /// A rotation about an axis through the body's origin.
    pub fn hinge(name: &str, body: usize, axis: [f64; 3]) -> Self {
        Self::new(name, body, JointKind::Hinge, axis)
    }

    /// Without limits, spring, damping or armature.
    fn new(name: &str, body: usize, kind: JointKind, axis: [f64; 3]) -> Self {
        let anchor = [0.0; 3];
        let softness = Softness::MUJOCO;
        let reference = 0.0;
        let range = None;
        let damping = 0.0;
        let armature = 0.0;
        let stiffness = 0.0;
        Self {
            name: name.into(),
            body,
            kind,
            axis,
            anchor,
            reference,
            range,
            damping,
            armature,
            stiffness,
            softness,
        }
    }
}
