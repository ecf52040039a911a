//! When a robot counts as healthy. An episode terminates on the step on which it stops being
//! healthy.

/// The health test, applied to the state after a step.
///
/// ```
/// use copq_envs::robot::{Preset, hopper};
///
/// // The hopper is healthy above 0.7 m and up to a pitch of 0.2.
/// let health = hopper(Preset::GymV5).health;
/// assert!(health.test(&[0.0, 1.25, 0.1, 0.0, 0.0, 0.0], &[0.0; 6]));
/// assert!(!health.test(&[0.0, 1.25, 0.3, 0.0, 0.0, 0.0], &[0.0; 6]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Health {
    /// Never terminates.
    Always,
    /// For robots in the x-z plane, with qpos = (x, z, pitch, joints). All intervals are open.
    Planar {
        /// Height of the torso (m).
        height: [f64; 2],
        /// Pitch of the torso qpos\[2\] (rad).
        pitch: [f64; 2],
        /// Every element of qpos\[2..\] and qvel must be smaller than this in absolute value;
        /// infinite for no test.
        bound: f64,
        /// What is added to qpos\[1\] to get the height (m).
        lift: f64,
    },
    /// For robots with a free root: the height qpos\[2\] (m) lies in an interval.
    Height {
        /// The interval.
        range: [f64; 2],
        /// Whether its ends are unhealthy.
        open: bool,
    },
}

impl Health {
    /// Whether this state is healthy. It needs at least three entries in `qpos`.
    pub fn test(&self, qpos: &[f64], qvel: &[f64]) -> bool {
        match self {
            Self::Always => true,
            Self::Height { range, open: true } => inside(qpos[2], range),
            Self::Height { range: [low, high], open: false } => (*low..=*high).contains(&qpos[2]),
            Self::Planar { height, pitch, bound, lift } => {
                inside(qpos[1] + lift, height)
                    && inside(qpos[2], pitch)
                    && qpos[2..].iter().chain(qvel).all(|value| value.abs() < *bound)
            }
        }
    }
}

fn inside(value: f64, [low, high]: &[f64; 2]) -> bool {
    *low < value && value < *high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_open_and_x_is_free() {
        let health = Health::Planar {
            height: [0.7, f64::INFINITY],
            pitch: [-0.2, 0.2],
            bound: 100.0,
            lift: 0.0,
        };
        assert!(health.test(&[1e6, 0.71, 0.19, 0.0], &[99.0]));
        assert!(!health.test(&[0.0, 0.7, 0.0, 0.0], &[0.0]));
        assert!(!health.test(&[0.0, 1.0, -0.2, 0.0], &[0.0]));
        assert!(!health.test(&[0.0, 1.0, 0.0, -100.0], &[0.0]));
        assert!(!health.test(&[0.0, 1.0, 0.0, 0.0], &[100.0]));
        assert!(!health.test(&[0.0, 1.0, 0.0, f64::NAN], &[0.0]));
    }

    #[test]
    fn heights_of_free_robots() {
        let closed = Health::Height { range: [0.2, 1.0], open: false };
        let open = Health::Height { range: [0.2, 1.0], open: true };
        for (z, wanted) in
            [(0.2, [true, false]), (0.5, [true, true]), (1.0, [true, false]), (1.1, [false; 2])]
        {
            assert_eq!([&closed, &open].map(|health| health.test(&[9.0, 9.0, z], &[])), wanted);
        }
        assert!(!closed.test(&[0.0, 0.0, f64::NAN], &[]));
    }
}
