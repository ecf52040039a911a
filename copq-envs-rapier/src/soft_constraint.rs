//! MuJoCo's soft constraints on rapier's solver.
//!
//! MuJoCo gives a violated constraint the acceleration `a = (1 - c) a0 + c (-b v - k d r)`: `a0` is
//! what it would be without the constraint's force, the bracket is a spring and damper that pull
//! the violation r (negative) to 0, and the share `c = A / (A + R)` compares the inverse mass A
//! along the constraint with its regularisation R. So `v' = (1 - c) v0 + c u` at the end of a
//! timestep, where `v0` is the velocity reached without the constraint and `u` a target velocity.
//! The target is such that spring and damper alone would take v to `v1 = (1 - c) v + c u`.
//!
//! rapier gets `v' = (1 - c) v0 + c u` from a spring without damping: `u` is minus the gap over dt,
//! and `c = s / (1 + s)` with s the square of the spring's angular frequency times dt. So a
//! frequency gives a constraint its share, and an artificial gap gives it its u. Used as intended,
//! rapier's springs can hold as stiffly, but then they stop whatever hits them in one timestep,
//! where MuJoCo takes ten or more.

use std::f64::consts::TAU;

use copq_envs::robot::Softness;
use rapier3d_f64::prelude::SpringCoefficients;

/// rapier's spring that takes this share, in (0, 1), of the velocity.
pub(crate) fn spring(share: f64, dt: f64) -> SpringCoefficients<f64> {
    SpringCoefficients::new((share / (1.0 - share)).sqrt() / (dt * TAU), 0.0)
}

/// The velocity v1 to which a constraint of this share alone takes `velocity` in dt, starting from
/// a violation of `position` (negative).
///
/// It solves x'' = -2 p x' - w2 x exactly: an approximation would fail where a timestep is half the
/// time constant.
pub(crate) fn relaxed(
    softness: &Softness,
    share: f64,
    position: f64,
    velocity: f64,
    dt: f64,
) -> f64 {
    let [damping, stiffness] = safe(softness, dt).reference();
    let p = 0.5 * share * damping;
    let w2 = share * stiffness * softness.impedance(position);
    let (cosine, sine) = wave(p * p - w2, dt);
    (-p * dt).exp() * (velocity * (cosine - p * sine) - w2 * position * sine)
}

/// cosh(t sqrt(x)) and sinh(t sqrt(x)) / sqrt(x), which are cosine and sine where x is negative.
fn wave(x: f64, t: f64) -> (f64, f64) {
    let root = x.abs().sqrt();
    if root * t < 1e-6 {
        (1.0, t)
    } else if x > 0.0 {
        ((root * t).cosh(), (root * t).sinh() / root)
    } else {
        ((root * t).cos(), (root * t).sin() / root)
    }
}

/// A time constant below two timesteps is unstable; MuJoCo also raises it.
fn safe(softness: &Softness, dt: f64) -> Softness {
    let [time_constant, damping_ratio] = softness.solref;
    Softness { solref: [time_constant.max(2.0 * dt), damping_ratio], ..*softness }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn the_spring_takes_its_share_and_corrects_in_one_step() {
        for (share, dt) in [(0.05, 0.002), (0.5, 0.01), (0.95, 0.003)] {
            let spring = spring(share, dt);
            assert_abs_diff_eq!(spring.cfm_factor(dt), share, epsilon = 1e-12);
            assert_abs_diff_eq!(spring.erp_inv_dt(dt) * dt, 1.0, epsilon = 1e-12);
        }
    }

    /// Against ten thousand small steps of the equation itself.
    #[test]
    fn relaxed_solves_the_constraints_own_motion() {
        for (solref, share) in [([0.02, 1.0], 0.95), ([0.02, 1.0], 0.3), ([0.05, 0.2], 0.8)] {
            let softness = Softness { solref, ..Softness::MUJOCO };
            let [damping, stiffness] = softness.reference();
            let d = softness.impedance(-0.1);
            let mut x = -0.1;
            let mut v = -2.0;
            let dt = 0.01;
            let exact = relaxed(&softness, share, x, v, dt);
            for _ in 0..10_000 {
                v += dt / 1e4 * share * (-damping * v - stiffness * d * x);
                x += dt / 1e4 * v;
            }
            assert_abs_diff_eq!(exact, v, epsilon = 1e-3);
        }
    }
}
