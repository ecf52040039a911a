//! MuJoCo's constraint softness as rapier's spring.

use std::f64::consts::TAU;

use copq_envs::RobotSpec;
use copq_envs::robot::Softness;
use rapier3d_f64::prelude::{Real, SpringCoefficients};

/// The spring with which rapier's constraint reacts as MuJoCo's does at impedance d:
/// omega = sqrt(1 / (d (1 - d))) / (tc dr), damping ratio 1 / ((1 - d) tc omega).
pub(crate) fn spring(softness: &Softness) -> SpringCoefficients<Real> {
    let (d, [time_constant, damping_ratio]) = (softness.impedance(), softness.solref);
    let omega = (d * (1.0 - d)).sqrt().recip() / (time_constant * damping_ratio);
    SpringCoefficients::new(omega / TAU, 1.0 / ((1.0 - d) * time_constant * omega))
}

/// The floor's spring for every contact: rapier has one for the whole world.
pub(crate) fn contact_spring(robot: &RobotSpec) -> SpringCoefficients<Real> {
    let floor = robot.geoms.iter().find(|geom| geom.body.is_none());
    spring(&floor.map_or(Softness::MUJOCO, |floor| floor.softness))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mujocos_default_limit() {
        let spring = spring(&Softness::MUJOCO);
        assert!((spring.natural_frequency - 36.51).abs() < 0.01, "{spring:?}");
        assert!((spring.damping_ratio - 4.359).abs() < 0.001, "{spring:?}");
    }
}
