//! What MuJoCo would do by itself and this engine must not: reset in silence, write files, lose
//! what a snapshot needs.

use crate::support::ENGINES;
use approx::assert_abs_diff_eq;
use copq::{Error, State};
use copq_envs::robot::{Preset, ant, hopper, humanoid};
use copq_envs::{Field, Physics, RobotSpec};
use copq_envs_mujoco::Mujoco;

const FIELDS: [Field; 6] = [
    Field::BodyPosition,
    Field::BodyCentre,
    Field::Inertia,
    Field::Velocity,
    Field::ActuatorForce,
    Field::ContactForce,
];

fn each(robot: &RobotSpec, test: impl Fn(Mujoco)) {
    ENGINES.iter().for_each(|make| test(make(robot).unwrap()));
}

/// Everything that one can see of a robot: state, then all fields.
fn everything(physics: &mut Mujoco, robot: &RobotSpec) -> Vec<f64> {
    let mut qpos = vec![0.0; robot.nq()];
    let mut qvel = vec![0.0; robot.nv()];
    physics.qpos(&mut qpos);
    physics.qvel(&mut qvel);
    let mut all = [qpos, qvel].concat();
    for field in FIELDS {
        let mut values = vec![0.0; field.len(robot)];
        physics.read(field, &mut values).unwrap();
        all.extend(values);
    }
    all
}

/// Controls that differ from step to step.
fn controls(robot: &RobotSpec, step: usize) -> Vec<f64> {
    (0..robot.nu()).map(|motor| 0.4 * ((step * 7 + motor * 3) % 11) as f64 / 10.0 - 0.2).collect()
}

fn run(physics: &mut Mujoco, robot: &RobotSpec, steps: std::ops::Range<usize>) -> Vec<f64> {
    steps.for_each(|step| physics.step(&controls(robot, step), robot.frame_skip).unwrap());
    everything(physics, robot)
}

fn assert_fails(physics: &mut Mujoco, what: &str) {
    let error = physics.step(&[0.0; 3], 4).unwrap_err();
    assert!(matches!(error, Error::Env { .. }), "{error}");
    let error = error.to_string();
    assert!(
        error.contains("hopper on MuJoCo") && error.contains(what) && error.contains("reset first"),
        "{error}"
    );
}

#[test]
fn states_that_mujoco_would_reset_in_silence_are_errors() {
    let robot = hopper(Preset::GymV5);
    let folder = std::env::current_dir().unwrap();
    each(&robot, |mut physics| {
        for (dof, value, what) in
            [(0, 1e11, "QPOS"), (9, 1e11, "QVEL"), (9, 1e9, "QACC"), (9, 1e200, "QVEL")]
        {
            let mut state = [&robot.initial_qpos[..], &[0.0; 6]].concat();
            state[dof] = value;
            let (qpos, qvel) = state.split_at(6);
            match physics.reset_to(qpos, qvel) {
                Err(error) => assert!(error.to_string().contains("reset first"), "{error}"),
                Ok(()) => assert_fails(&mut physics, what),
            }
            assert_fails(&mut physics, "after an error");
            // A reset mends it.
            physics.reset_to(&robot.initial_qpos, &[0.0; 6]).unwrap();
            physics.step(&[0.0; 3], 4).unwrap();
        }
    });
    assert!(!folder.join("MUJOCO_LOG.TXT").exists());
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let robot = hopper(Preset::GymV5);
    each(&robot, |mut physics| {
        assert!(physics.reset_to(&[0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0], &[0.0; 6]).is_err());
        assert!(physics.reset_to(&robot.initial_qpos, &[f64::INFINITY; 6]).is_err());
        assert!(physics.reset_to(&[0.0; 5], &[0.0; 6]).is_err());
        assert!(
            physics
                .step(&[0.0, f64::NAN, 0.0], 1)
                .unwrap_err()
                .to_string()
                .contains("control is not finite")
        );
        assert!(physics.step(&[0.0; 2], 1).is_err());
        physics.step(&[0.0; 3], 1).unwrap();
    });
}

/// The ant and the humanoid stand on the floor: contacts, warm starts, and fields that lag.
#[test]
fn a_snapshot_goes_on_bit_for_bit_and_tells_the_same() {
    for robot in [ant(Preset::GymV5), humanoid(Preset::GymV5), humanoid(Preset::Paper)] {
        each(&robot, |mut physics| {
            run(&mut physics, &robot, 0..40);
            let mut state = State::default();
            physics.save(&mut state).unwrap();
            let now = everything(&mut physics, &robot);
            let later = run(&mut physics, &robot, 40..80);
            physics.load(&state).unwrap();
            assert!(
                everything(&mut physics, &robot) == now
                    && run(&mut physics, &robot, 40..80) == later
            );
            // In a new engine too; and a snapshot of it is the same snapshot.
            let make =
                ENGINES.iter().find(|make| make(&robot).unwrap().name() == physics.name()).unwrap();
            let mut other = make(&robot).unwrap();
            other.load(&state).unwrap();
            let mut again = State::default();
            other.save(&mut again).unwrap();
            assert!(again == state && everything(&mut other, &robot) == now);
            assert!(run(&mut other, &robot, 40..80) == later);
        });
    }
}

#[test]
fn foreign_snapshots_are_refused() {
    let robot = hopper(Preset::GymV5);
    each(&robot, |mut physics| {
        let mut state = State::default();
        assert!(physics.load(&state).is_err());
        physics.save(&mut state).unwrap();
        for (key, value) in [("engine", "MuJoCo 1.0.0"), ("robot", "cat")] {
            let mut foreign = state.clone();
            foreign.put(key, value.as_bytes());
            let error = physics.load(&foreign).unwrap_err().to_string();
            assert!(
                error.contains(&format!("{key} of a saved state")) && error.contains(value),
                "{error}"
            );
        }
        let mut short = state.clone();
        short.put("qacc_warmstart", [0.0]);
        assert!(physics.load(&short).unwrap_err().to_string().contains("qacc_warmstart"));
        physics.load(&state).unwrap();
        physics.step(&[0.0; 3], 1).unwrap();
    });
    // The paper's hopper counts its height from another place.
    ENGINES.iter().for_each(|make| {
        let mut state = State::default();
        make(&hopper(Preset::Paper)).unwrap().save(&mut state).unwrap();
        assert!(
            make(&robot)
                .unwrap()
                .load(&state)
                .unwrap_err()
                .to_string()
                .contains("different numbers")
        );
    });
}

#[test]
fn contact_forces_are_zero_after_a_reset_and_hold_the_robot_up() {
    let robot = ant(Preset::GymV5);
    each(&robot, |mut physics| {
        let mut forces = vec![1.0; Field::ContactForce.len(&robot)];
        physics.read(Field::ContactForce, &mut forces).unwrap();
        assert!(forces.iter().all(|&force| force == 0.0));
        // At rest, the floor carries what gravity pulls.
        (0..200).for_each(|_| physics.step(&[0.0; 8], robot.frame_skip).unwrap());
        physics.read(Field::ContactForce, &mut forces).unwrap();
        let up: f64 = forces.chunks(6).map(|body| body[5]).sum();
        let weight = 9.81 * robot.total_mass();
        assert_abs_diff_eq!(up, weight, epsilon = 1e-3 * weight);
    });
}

#[test]
fn mass_and_centre_are_those_of_the_current_position() {
    let robot = humanoid(Preset::GymV5);
    each(&robot, |mut physics| {
        let matrix = physics.mass_matrix().unwrap();
        // Pushing the free joint along an axis pushes all the mass.
        for i in 0..3 {
            assert_abs_diff_eq!(matrix[i * 23 + i], robot.total_mass(), epsilon = 1e-9);
        }
        for i in 0..23 * 23 {
            assert_abs_diff_eq!(matrix[i], matrix[i % 23 * 23 + i / 23], epsilon = 1e-12);
        }
        let mut qpos = robot.initial_qpos.clone();
        let [_, _, z] = physics.centre_of_mass().unwrap();
        qpos[2] += 0.5;
        physics.reset_to(&qpos, &[0.0; 23]).unwrap();
        assert_abs_diff_eq!(physics.centre_of_mass().unwrap()[2], z + 0.5, epsilon = 1e-12);
    });
}

#[test]
fn the_engine_can_be_sent_to_a_thread() {
    fn is_send<T: Send>() {}
    is_send::<Mujoco>();
}
