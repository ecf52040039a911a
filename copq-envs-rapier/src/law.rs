//! MuJoCo's soft constraints on rapier's solver.
//!
//! MuJoCo gives a violated constraint the acceleration `a = (1 - c) a0 + c aref`: `a0` is what it would be without the
//! constraint's force, `aref` that of a spring and damper, and the share `c = A / (A + R)` compares the inverse mass A along
//! the constraint with its regularisation R. Over a timestep, with `v` the velocity at its start, that is
//!
//! ```text
//! v' = (1 - c) v0 + c (v + dt aref)
//! ```
//!
//! rapier makes `v' = (1 - c) v0 + c u` of a spring without damping, where `u` is the gap over dt and
//! `c = s / (1 + s)`, s the square of the spring's angular frequency times dt. So a constraint gets its share from the
//! frequency, and its gap from `u = v + dt aref`. rapier's own springs hold as stiffly, but stop what hits them within
//! a timestep, where MuJoCo takes ten or more.

use std::f64::consts::TAU;

use copq_envs::robot::Softness;
use rapier3d_f64::prelude::SpringCoefficients;

/// rapier's spring that takes this share, in (0, 1), of the velocity.
pub(crate) fn spring(share: f64, dt: f64) -> SpringCoefficients<f64> {
    SpringCoefficients::new((share / (1.0 - share)).sqrt() / (dt * TAU), 0.0)
}

/// The velocity u to strive for, from a violated constraint's position (negative) and its rate of change.
pub(crate) fn target(softness: &Softness, position: f64, velocity: f64, dt: f64) -> f64 {
    velocity + dt * safe(softness, dt).acceleration(position, velocity)
}

/// A time constant below two timesteps is unstable; MuJoCo raises it, too.
fn safe(softness: &Softness, dt: f64) -> Softness {
    let [time_constant, damping_ratio] = softness.solref;
    Softness { solref: [time_constant.max(2.0 * dt), damping_ratio], ..*softness }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spring_takes_its_share_and_corrects_in_one_step() {
        for (share, dt) in [(0.05, 0.002), (0.5, 0.01), (0.95, 0.003)] {
            let spring = spring(share, dt);
            assert!((spring.cfm_factor(dt) - share).abs() < 1e-12, "{spring:?}");
            assert!((spring.erp_inv_dt(dt) * dt - 1.0).abs() < 1e-12, "{spring:?}");
        }
    }
}
