//! MuJoCo's friction pyramid, seen from the contact's normal.
//!
//! MuJoCo builds a contact with friction mu from four constraints on the edges of a pyramid. Each
//! softly enforces `v -+ mu w >= 0`, where v is the velocity of separation and w the velocity
//! across, in one of two directions. This has two effects that rapier's contacts lack. All four
//! together are softer along the normal than one constraint would be; for a mu of 2, ten times
//! softer. And a contact that slides separates: one edge alone carries it, and that edge comes to
//! rest only at `v = mu w`.

use copq_envs::robot::Softness;

use crate::soft_constraint::relaxed;

/// The inverse mass A in MuJoCo's R is not the contact's own but a mean over directions, at the
/// body's centre in the reference pose. In random rollouts the contact's own, which rapier uses, is
/// 1.6 (hopper), 1.9 (walker), 2.1 (halfcheetah), 1.0 (ant) and 1.6 (humanoid) times as large
/// (medians).
const TRUE_INVERSE_MASS: f64 = 1.5;

/// The share of the acceleration that a contact takes if it does not slide. Each of its four edges
/// has `R = 2 mu^2 (1 + mu^2) A (1 - d) / d`; together they have a quarter of that.
pub(crate) fn stuck_share(impedance: f64, friction: f64) -> f64 {
    let square = friction * friction;
    share(impedance, if friction > 0.0 { 0.5 * square * (1.0 + square) } else { 1.0 })
}

/// The share that one edge takes alone; its inverse mass is `A (1 + mu^2)`.
fn sliding_share(impedance: f64, friction: f64) -> f64 {
    share(impedance, 2.0 * friction * friction)
}

fn share(impedance: f64, regularisation: f64) -> f64 {
    let strength = TRUE_INVERSE_MASS * impedance / (1.0 - impedance) / regularisation;
    (strength / (1.0 + strength)).min(0.9999)
}

/// What a timestep of contact alone adds to the velocity of separation, at `distance` (negative)
/// and with these speeds apart and across.
pub(crate) fn gain(
    softness: &Softness,
    friction: f64,
    distance: f64,
    [apart, across]: [f64; 2],
    dt: f64,
) -> f64 {
    let impedance = softness.impedance(distance);
    let gain =
        |share: f64, velocity: f64| relaxed(softness, share, distance, velocity, dt) - velocity;
    let stuck = gain(stuck_share(impedance, friction), apart);
    if friction == 0.0 {
        return stuck;
    }
    let edge = gain(sliding_share(impedance, friction), apart - friction * across);
    stuck.max(edge / (1.0 + friction * friction))
}

#[cfg(test)]
mod tests {
    use approx::{abs_diff_eq, assert_abs_diff_eq};

    use super::*;

    #[test]
    fn feet_are_soft_and_smooth_contacts_are_not() {
        let soft = |friction| stuck_share(0.8, friction) / (1.0 - stuck_share(0.8, friction));
        assert_abs_diff_eq!(soft(1.0) / soft(2.0), 10.0, epsilon = 1e-9);
        assert_abs_diff_eq!(soft(1.0), soft(0.0), epsilon = 1e-9);
        assert_abs_diff_eq!(soft(1.0), 6.0, epsilon = 1e-9);
    }

    /// Stiff contacts, given the time: they stick at rest, or slide and part with
    /// `mu s / (1 + mu^2)`, where `s = w + mu v`.
    #[test]
    fn a_sliding_contact_parts() {
        let stiff = Softness { solref: [0.02, 1.0], solimp: [0.9999, 0.9999, 0.001, 0.5, 2.0] };
        let change = |speeds| gain(&stiff, 1.0, -1e-12, speeds, 0.01);
        let time = change([-1.0, 0.0]);
        for (apart, across, wanted) in
            [(-1.0, 0.5, 0.0), (-1.0, 3.0, 1.0), (-1.0, 1.0, 0.0), (0.0, 2.0, 1.0)]
        {
            let after = apart + change([apart, across]) / time;
            assert!(abs_diff_eq!(after, wanted, epsilon = 1e-3), "{apart} {across}: {after}");
        }
    }
}
