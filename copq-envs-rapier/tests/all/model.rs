//! Poses, masses, inertia and velocities of every robot against MuJoCo's, in a random pose and
//! motion.

use crate::support;
use approx::assert_abs_diff_eq;

use copq_envs::robot::Preset;
use copq_envs::{Field, Physics};
use copq_envs_rapier::Rapier;
use support::crane::crane;
use support::{ROBOTS, data, qpos, qvel, robot, row, worst};

fn each(test: impl Fn(&str, &mut Rapier, &str)) {
    for name in ROBOTS {
        for (preset, label) in [(Preset::GymV5, "gym-v5"), (Preset::Paper, "paper")] {
            let golden = data(&format!("state_{name}_{label}.csv"));
            let mut physics = Rapier::new(&robot(name, preset)).unwrap();
            physics.reset_to(&row(&golden, "qpos"), &row(&golden, "qvel")).unwrap();
            test(&format!("{name} {label}"), &mut physics, &golden);
        }
    }
}

#[test]
fn a_state_comes_back() {
    each(|name, physics, golden| {
        assert!(worst(&qpos(physics), &row(golden, "qpos")) < 1e-15 * 4.0, "{name}");
        assert!(worst(&qvel(physics), &row(golden, "qvel")) < 1e-15 * 8.0, "{name}");
    });
}

#[test]
fn the_mass_matrix_is_mujocos() {
    each(|name, physics, golden| {
        let error = worst(&physics.mass_matrix().unwrap(), &row(golden, "mass"));
        println!("{name}: {error:e}");
        assert!(error < 1e-9, "{name}: {error:e}");
    });
}

/// The diagonal at the reference pose, against what MuJoCo compiles from Gymnasium's own models:
/// ours have no part in it.
#[test]
fn the_mass_matrix_is_that_of_gymnasiums_models() {
    let golden = data("mass_gym.csv");
    for name in ROBOTS {
        let mut physics = Rapier::new(&robot(name, Preset::GymV5)).unwrap();
        let wanted = row(&golden, &format!("{name}_mass"));
        physics
            .reset_to(&row(&golden, &format!("{name}_qpos0")), &vec![0.0; wanted.len()])
            .unwrap();
        let matrix = physics.mass_matrix().unwrap();
        let got: Vec<f64> = matrix.iter().copied().step_by(wanted.len() + 1).collect();
        let error = worst(&got, &wanted);
        assert!(error < 1e-9, "{name}: {error:e}");
    }
}

#[test]
fn the_centre_of_mass_is_mujocos() {
    each(|name, physics, golden| {
        let error = worst(&physics.centre_of_mass().unwrap(), &row(golden, "com"));
        assert!(error < 1e-12, "{name}: {error:e}");
    });
}

#[test]
fn the_fields_are_mujocos() {
    let fields = [
        (Field::BodyPosition, "xpos"),
        (Field::BodyCentre, "xipos"),
        (Field::Inertia, "cinert"),
        (Field::Velocity, "cvel"),
    ];
    each(|name, physics, golden| {
        for (field, array) in fields {
            let wanted = row(golden, array);
            let mut got = vec![0.0; wanted.len()];
            physics.read(field, &mut got).unwrap();
            let error = worst(&got, &wanted);
            assert!(error < 1e-9, "{name} {array}: {error:e}");
        }
    });
}

/// Tilted axes, slides after hinges, anchors, welded bodies, several roots and one in the world.
#[test]
fn a_machine_of_every_kind_of_joint_is_mujocos() {
    let golden = data("state_crane.csv");
    let mut physics = Rapier::new(&crane()).unwrap();
    physics.reset_to(&row(&golden, "qpos"), &row(&golden, "qvel")).unwrap();
    assert!(worst(&qpos(&physics), &row(&golden, "qpos")) < 1e-14);
    assert!(worst(&physics.mass_matrix().unwrap(), &row(&golden, "mass")) < 1e-9);
    assert!(worst(&physics.centre_of_mass().unwrap(), &row(&golden, "com")) < 1e-12);
    for (field, array) in [(Field::BodyPosition, "xpos"), (Field::BodyCentre, "xipos")] {
        let mut got = [0.0; 21];
        physics.read(field, &mut got).unwrap();
        assert!(worst(&got, &row(&golden, array)) < 1e-12, "{array}");
    }
}

/// A quaternion and its negative are one rotation; which of them was set is told, and stays while
/// the body turns.
#[test]
fn quaternions_keep_their_sign() {
    let spec = robot("ant", Preset::Paper);
    let mut physics = Rapier::new(&spec).unwrap();
    let mut pose = spec.initial_qpos.clone();
    pose[2] = 20.0;
    pose[3..7].copy_from_slice(&[-0.8, 0.36, 0.48, 0.0]);
    physics.reset_to(&pose, &[0.5; 14]).unwrap();
    assert!(worst(&qpos(&physics)[3..7], &pose[3..7]) < 1e-15);
    let mut before = qpos(&physics);
    for _ in 0..100 {
        physics.step(&[0.1; 8], 1).unwrap();
        let after = qpos(&physics);
        assert!(worst(&before[3..7], &after[3..7]) < 0.05, "{before:?} {after:?}");
        assert_abs_diff_eq!(after[3..7].iter().map(|x| x * x).sum::<f64>(), 1.0, epsilon = 1e-12);
        before = after;
    }
}
