//! What robots in the x-z plane share: a root that slides along x and z and pitches about y.

use super::{Joint, Softness};

/// The root joints, x, z and pitch, of body 0. Both slides act along lines through `anchor_z` (m, in the body frame, which
/// changes nothing); qpos of z is `height` at the reference pose.
pub(super) fn root(height: f64, softness: Softness) -> Vec<Joint> {
    let anchor = [0.0, 0.0, -height];
    vec![
        Joint { anchor, softness, ..Joint::slide("rootx", 0, [1.0, 0.0, 0.0]) },
        Joint { anchor, reference: height, softness, ..Joint::slide("rootz", 0, [0.0, 0.0, 1.0]) },
        Joint { softness, ..Joint::hinge("rooty", 0, [0.0, 1.0, 0.0]) },
    ]
}
