//! What robots in the x-z plane share: a root that slides along x and z and pitches about y.

use super::{Joint, Softness};

/// 150 degrees (rad) as Brax rounds them.
pub(super) const BRAX_150: f64 = 2.61799;
/// 45 degrees (rad) as Brax rounds them.
#[expect(clippy::approx_constant, reason = "the rounding is the fact")]
pub(super) const BRAX_45: f64 = 0.785398;

/// The root joints, x, z and pitch, of body 0. qpos of z is `height` (m) at the reference pose; the slides' axes pass
/// that far below the body, which changes nothing.
pub(super) fn root(height: f64, softness: Softness) -> Vec<Joint> {
    let anchor = [0.0, 0.0, -height];
    vec![
        Joint { anchor, softness, ..Joint::slide("rootx", 0, [1.0, 0.0, 0.0]) },
        Joint { anchor, reference: height, softness, ..Joint::slide("rootz", 0, [0.0, 0.0, 1.0]) },
        Joint { softness, ..Joint::hinge("rooty", 0, [0.0, 1.0, 0.0]) },
    ]
}
