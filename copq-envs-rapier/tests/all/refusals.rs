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
    physics
        .reset_to(&[0.0, 1.25, 0.0, 0.0, 0.0, 0.0], &[0.0, 0.0, 1e308, 0.0, 0.0, -1e308])
        .unwrap();
    let error = (0..50).find_map(|_| physics.step(&[0.0; 3], 4).err()).unwrap();
    assert!(
        matches!(error, Error::Env { .. }) && error.to_string().contains("stopped being finite"),
        "{error}"
    );
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
fn a_free_joint_in_the_wrong_place_is_named() {
    let mut inner = robot::hopper(Preset::GymV5);
    inner.joints[3].kind = JointKind::Free;
    inner.initial_qpos = vec![0.0; inner.nq()];
    inner.actuators.remove(0);
    let error = Rapier::new(&inner).unwrap_err().to_string();
    assert!(
        error.contains("a lone free joint") && error.contains("thigh_joint on thigh"),
        "{error}"
    );
}

#[test]
fn a_free_joint_needs_no_axis() {
    let mut spec = robot::ant(Preset::GymV5);
    spec.joints[0].axis = [0.0; 3];
    Rapier::new(&spec).unwrap();
}

#[test]
fn a_robot_without_joints_is_refused() {
    let mut spec = robot::hopper(Preset::GymV5);
    spec.joints.clear();
    spec.actuators.clear();
    spec.initial_qpos.clear();
    assert!(Rapier::new(&spec).is_err());
}

/// Geoms that touch the same others share one of rapier's 32 groups; these all differ.
#[test]
fn more_kinds_of_geom_than_collision_groups_are_refused() {
    let mut spec = robot::hopper(Preset::GymV5);
    let floor = Geom { name: String::new(), ..spec.geoms[0].clone() };
    spec.geoms.resize(100, floor);
    Rapier::new(&spec).unwrap();
    for (index, geom) in spec.geoms.iter_mut().enumerate() {
        geom.body = (index % 2 == 0).then_some(0);
        (geom.contype, geom.conaffinity) =
            if index < 66 { (1 << (index / 2 % 32), 1 << (index % 32)) } else { (1, 1) };
    }
    assert!(Rapier::new(&spec).unwrap_err().to_string().contains("at most 32"));
}
