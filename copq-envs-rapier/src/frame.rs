//! Positions, quaternions and axes of a [`RobotSpec`](copq_envs::RobotSpec) as rapier's poses.

use rapier3d_f64::prelude::{Pose, Rotation, Vector};

/// A rotation from (w, x, y, z), normalised; a length of 0 means no rotation, as in MuJoCo.
pub(crate) fn rotation([w, x, y, z]: [f64; 4]) -> Rotation {
    match Rotation::from_xyzw(x, y, z, w) {
        none if none.length_squared() == 0.0 => Rotation::IDENTITY,
        some => some.normalize(),
    }
}

/// A pose from a position and (w, x, y, z).
pub(crate) fn pose(pos: [f64; 3], quat: [f64; 4]) -> Pose {
    Pose::from_parts(Vector::from_array(pos), rotation(quat))
}

/// No turn, or a half turn about an axis: enough to turn directions along the axes into positive
/// axes.
const TURNS: [[f64; 4]; 4] =
    [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A turned frame in which each of these directions is a positive axis, and which axes (0..3) they
/// are.
///
/// Frames stay aligned with the body's own where they can. Rotating every hinge onto x, as rapier's
/// revolute joint does, puts rounding noise into directions that a planar robot cannot move in; in
/// single precision this noise swallows all ground friction.
pub(crate) fn aligned(directions: &[[f64; 3]]) -> Option<(Rotation, Vec<usize>)> {
    TURNS.iter().find_map(|&turn| {
        let turn = Rotation::from_array(turn);
        let axes = directions.iter().map(|&direction| axis(turn, Vector::from_array(direction)));
        Some((turn, axes.collect::<Option<Vec<_>>>()?))
    })
}

fn axis(turn: Rotation, direction: Vector) -> Option<usize> {
    let local = turn.inverse() * direction;
    let is_along = |unit: &Vector| local * *unit == local && local.dot(*unit) > 0.0;
    [Vector::X, Vector::Y, Vector::Z].iter().position(is_along)
}

/// A turned frame whose x axis is this direction (not zero).
pub(crate) fn tilted(direction: [f64; 3]) -> Rotation {
    Rotation::from_rotation_arc(Vector::X, Vector::from_array(direction).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_one_at_any_length() {
        let long = aligned(&[[0.0, 2.0, 0.0], [0.0, 0.0, -0.7]]).unwrap();
        assert_eq!(long, aligned(&[[0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).unwrap());
        assert_eq!(long.1, [1, 2]);
        assert!(aligned(&[[1.0, 1.0, 0.0]]).is_none());
    }

    #[test]
    fn a_quaternion_of_zeros_is_no_rotation() {
        assert_eq!(rotation([0.0; 4]), rotation([1.0, 0.0, 0.0, 0.0]));
        assert_eq!(rotation([0.0, 0.0, 3.0, 0.0]), rotation([0.0, 0.0, 1.0, 0.0]));
    }
}
