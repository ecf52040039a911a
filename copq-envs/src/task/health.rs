//! When a robot counts as healthy; an episode terminates on the step where it stops to.

/// The test, on the state after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Health {
    /// Never terminates.
    Always,
    /// For robots in the x-z plane, qpos = (x, z, pitch, joints): all bounds are open intervals.
    Planar {
        /// Height of the torso qpos\[1\] (m).
        height: [f64; 2],
        /// Pitch of the torso qpos\[2\] (rad).
        pitch: [f64; 2],
        /// Every element of qpos\[2..\] and qvel must be smaller than this in size; infinite for no test.
        bound: f64,
    },
}

impl Health {
    /// Whether this state is healthy. A planar test needs at least three entries in `qpos`.
    pub fn test(&self, qpos: &[f64], qvel: &[f64]) -> bool {
        match self {
            Self::Always => true,
            Self::Planar { height, pitch, bound } => {
                inside(qpos[1], height)
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
        let health = Health::Planar { height: [0.7, f64::INFINITY], pitch: [-0.2, 0.2], bound: 100.0 };
        assert!(health.test(&[1e6, 0.71, 0.19, 0.0], &[99.0]));
        assert!(!health.test(&[0.0, 0.7, 0.0, 0.0], &[0.0]));
        assert!(!health.test(&[0.0, 1.0, -0.2, 0.0], &[0.0]));
        assert!(!health.test(&[0.0, 1.0, 0.0, -100.0], &[0.0]));
        assert!(!health.test(&[0.0, 1.0, 0.0, 0.0], &[100.0]));
        assert!(!health.test(&[0.0, 1.0, 0.0, f64::NAN], &[0.0]));
    }
}
