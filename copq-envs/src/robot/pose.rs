//! A place and an orientation.

use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion, Vector3};

/// A frame in world axes.
///
/// ```
/// use std::f64::consts::FRAC_1_SQRT_2;
///
/// use copq_envs::robot::Pose;
///
/// // A frame 1 m along x, turned to the left by a right angle.
/// let frame = Pose::WORLD.at([1.0, 0.0, 0.0], [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
/// let [x, y, z] = frame.point([2.0, 0.0, 0.0]);
/// assert!((x - 1.0).abs() < 1e-12 && (y - 2.0).abs() < 1e-12 && z == 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Origin (m).
    pub pos: [f64; 3],
    /// Unit quaternion (w, x, y, z).
    pub quat: [f64; 4],
}

impl Pose {
    /// The world's own frame.
    pub const WORLD: Self = Self { pos: [0.0; 3], quat: [1.0, 0.0, 0.0, 0.0] };

    /// World coordinates of a point of this frame (m).
    pub fn point(&self, local: [f64; 3]) -> [f64; 3] {
        (self.isometry() * Point3::from(local)).into()
    }

    /// The frame at `pos` in this one, rotated by `quat`. A quaternion of length 0 means no
    /// rotation, as in MuJoCo.
    pub fn at(&self, pos: [f64; 3], quat: [f64; 4]) -> Self {
        (self.isometry() * Self { pos, quat }.isometry()).into()
    }

    /// This frame moved along one of its own axes (m).
    pub(super) fn slid(&self, axis: [f64; 3], by: f64) -> Self {
        let step = Vector3::from(axis).normalize() * by;
        Self { pos: self.point(step.into()), ..*self }
    }

    /// This frame rotated about one of its own axes (rad); its point `anchor` stays fixed.
    pub(super) fn rotated(&self, axis: [f64; 3], by: f64, anchor: [f64; 3]) -> Self {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(axis).normalize() * by);
        let about = Isometry3::rotation_wrt_point(rotation, anchor.into());
        (self.isometry() * about).into()
    }

    fn isometry(&self) -> Isometry3<f64> {
        let [w, x, y, z] = self.quat;
        let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0);
        Isometry3::from_parts(self.pos.into(), rotation.unwrap_or_default())
    }
}

impl From<Isometry3<f64>> for Pose {
    fn from(isometry: Isometry3<f64>) -> Self {
        let quaternion = isometry.rotation;
        Self {
            pos: isometry.translation.vector.into(),
            quat: [quaternion.w, quaternion.i, quaternion.j, quaternion.k],
        }
    }
}
