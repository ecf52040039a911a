//! A place and an orientation, and the quaternions they take.

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
        add(self.pos, self.direction(local))
    }

    /// World components of a vector of this frame.
    pub fn direction(&self, local: [f64; 3]) -> [f64; 3] {
        let [w, axis @ ..] = self.quat;
        let turned = cross(axis, local);
        let twice = cross(axis, turned);
        [0, 1, 2].map(|i| local[i] + 2.0 * (w * turned[i] + twice[i]))
    }

    /// The frame that lies at `pos`, turned by `quat`, in this one.
    pub fn at(&self, pos: [f64; 3], quat: [f64; 4]) -> Self {
        Self { pos: self.point(pos), quat: normalised(product(self.quat, quat)) }
    }

    /// This frame moved along one of its own unit axes (m).
    pub(super) fn slid(&self, axis: [f64; 3], by: f64) -> Self {
        Self { pos: self.point(axis.map(|x| x * by)), ..*self }
    }

    /// This frame turned about one of its own unit axes (rad); the point `anchor` of it stays.
    pub(super) fn turned(&self, axis: [f64; 3], by: f64, anchor: [f64; 3]) -> Self {
        let (sine, cosine) = (by / 2.0).sin_cos();
        let [x, y, z] = axis.map(|x| x * sine);
        let turned = self.at(anchor, [cosine, x, y, z]);
        Self { pos: turned.point(anchor.map(|x| -x)), ..turned }
    }
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + b[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Hamilton's product: the rotation `b`, then `a`.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The quaternion scaled to length 1; one of length 0 becomes no rotation, as in MuJoCo.
pub(super) fn normalised(quat: [f64; 4]) -> [f64; 4] {
    let norm = quat.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 0.0 { quat.map(|x| x / norm) } else { Pose::WORLD.quat }
}
