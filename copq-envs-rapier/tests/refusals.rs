//! What cannot be simulated is an error that says so, never a panic and never a silent reset.

use copq::Error;
use copq_envs::robot::{Geom, JointKind, Preset};
use copq_envs::{Physics, robot};
use copq_envs_rapier::{Rapier, make};

#[test]
fn an_unknown_environment_is_answered_with_the_nearest() {
    let Err(error) = make("a/hoper") else { panic!("there is no a/hoper") };
    assert!(error.to_string().contains("'a/hoper'; known: a/hopper"), "{error}");
}

#[test]
fn a_state_that_blows_up_is_an_error() {
    let mut physics = Rapier::new(&robot::hopper(Preset::GymV5)).unwrap();
    physics.reset_to(&[0.0, 1.25, 0.0, 0.0, 0.0, 0.0], &[0.0, 0.0, 1e200, 0.0, 0.0, -1e200]).unwrap();
    let error = (0..50).find_map(|_| physics.step(&[0.0; 3], 4).err()).unwrap();
    assert!(matches!(error, Error::Env { .. }) && error.to_string().contains("stopped being finite"), "{error}");
    // A reset mends it.
    physics.reset_to(&[0.0, 1.25, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]).unwrap();
    physics.step(&[0.0; 3], 4).unwrap();
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let mut physics = Rapier::new(&robot::hopper(Preset::GymV5)).unwrap();
    assert!(physics.reset_to(&[0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]).is_err());
    physics.reset_to(&[0.0, 1.25, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]).unwrap();
    assert!(physics.step(&[0.0, f64::INFINITY, 0.0], 1).is_err());
    assert!(physics.step(&[0.0; 2], 1).is_err());
}

#[test]
fn joints_that_are_not_supported_yet_are_named() {
    let mut tilted = robot::hopper(Preset::GymV5);
    tilted.joints[3].axis = [0.6, -0.8, 0.0];
    let mut free = robot::hopper(Preset::GymV5);
    free.joints[0].kind = JointKind::Free;
    free.initial_qpos = vec![0.0; free.nq()];
    let mut twice = robot::hopper(Preset::GymV5);
    twice.joints[4].body = 1;
    for (spec, body) in [(tilted, "thigh"), (free, "torso"), (twice, "thigh")] {
        let error = Rapier::new(&spec).unwrap_err().to_string();
        assert!(error.contains(&format!("joints of hopper's {body}")), "{error}");
    }
}

#[test]
fn more_geoms_than_collision_groups_are_refused() {
    let mut spec = robot::hopper(Preset::GymV5);
    let floor: Geom = spec.geoms[0].clone();
    spec.geoms.resize(33, floor);
    assert!(Rapier::new(&spec).unwrap_err().to_string().contains("at most 32"));
}
