//! Contacts against MuJoCo's.

use crate::support;

use approx::assert_abs_diff_eq;
use copq_envs::robot::Preset;
use copq_envs::{Field, Physics};
use copq_envs_rapier::Rapier;
use support::{ROBOTS, Table, controls, data, qpos, qvel, robot, worst};

/// Timesteps until the second end of the foot lands, too.
const TOE: usize = 38;

/// The hopper lands on its foot from 0.3 m. In MuJoCo the foot goes 46 mm into the floor and comes
/// back out; springs that hold as stiffly but stop the foot at once, as rapier's own do, let it go
/// 3 mm.
#[test]
fn a_landing_gives_way_and_rebounds_as_in_mujoco() {
    let golden = Table::parse(&data("landing_hopper.csv"));
    let mut physics = Rapier::new(&robot("hopper", Preset::GymV5)).unwrap();
    physics.reset_to(&golden.vector(0, "qpos"), &golden.vector(0, "qvel")).unwrap();
    let mut height = 0.0_f64;
    let mut rates = 0.0_f64;
    for step in 1..golden.len() {
        physics.step(&[0.0; 3], 1).unwrap();
        height = height
            .max((physics.centre_of_mass().unwrap()[2] - golden.get(step, "comz").unwrap()).abs());
        if step <= TOE {
            rates = rates.max(worst(&qvel(&physics), &golden.vector(step, "qvel")));
        }
    }
    println!("height of the centre of mass: {height:.4} m, joint rates: {rates:.3} rad/s");
    assert!(height < 0.006 && rates < 0.2);
}

/// Errors of velocity after one environment step in contact, as a share of what the step changed:
/// medians over states of the norm, so that a contact found a timestep earlier or later does not
/// decide.
#[test]
fn one_step_in_contact_is_nearly_mujocos() {
    let bounds = [0.15, 0.25, 0.05, 0.05, 0.12];
    for (name, bound) in ROBOTS.iter().zip(bounds) {
        let golden = Table::parse(&data(&format!("onestep_{name}.csv")));
        let spec = robot(name, Preset::GymV5);
        let mut physics = Rapier::new(&spec).unwrap();
        let mut errors: Vec<f64> = (0..golden.len())
            .map(|row| {
                let before = golden.vector(row, "qvel");
                let after = golden.vector(row, "nqvel");
                physics.reset_to(&golden.vector(row, "qpos"), &before).unwrap();
                physics.step(&controls(&spec, &golden.vector(row, "u")), spec.frame_skip).unwrap();
                distance(&qvel(&physics), &after) / distance(&before, &after)
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        println!("{name}: {:.3} (worst {:.3})", errors[6], errors[11]);
        assert!(errors[6] < bound, "{name}: {errors:?}");
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Pushing off with all four ankles for 0.2 s, in timesteps of 0.001 s. MuJoCo's ant reaches 0.716
/// to 0.737 m in such steps and 0.719 to 0.722 m in steps of 0.0002 s; in its own of 0.01 s, where
/// contacts chatter, it reaches 0.90 m.
#[test]
fn the_ant_stands_and_jumps_as_high_as_in_mujoco() {
    let mut spec = robot("ant", Preset::GymV5);
    spec.timestep = 0.001;
    let mut physics = Rapier::new(&spec).unwrap();
    let mut pose = robot("ant", Preset::Paper).initial_qpos;
    pose[2] = 0.75;
    physics.reset_to(&pose, &[0.0; 14]).unwrap();
    physics.step(&[0.0; 8], 800).unwrap();
    assert_abs_diff_eq!(qpos(&physics)[2], 0.574, epsilon = 0.005);
    physics.step(&[0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, -1.0], 200).unwrap();
    let highest = (0..300).fold(qpos(&physics)[2], |highest, _| {
        physics.step(&[0.0; 8], 1).unwrap();
        highest.max(qpos(&physics)[2])
    });
    assert_abs_diff_eq!(highest, 0.72, epsilon = 0.015);
}

/// Forces are told as they act: with gravity, their sum over a fall onto the floor is the change of
/// the whole robot's momentum.
#[test]
fn contact_forces_balance_momentum() {
    for name in ROBOTS {
        let spec = robot(name, Preset::Paper);
        let mut physics = Rapier::new(&spec).unwrap();
        physics.reset_to(&spec.initial_qpos, &vec![0.0; spec.nv()]).unwrap();
        let steps = 0.4 / spec.timestep;
        let mut impulse = [0.0; 3];
        for _ in 0..steps as usize {
            physics.step(&vec![0.0; spec.nu()], 1).unwrap();
            let force = total(&mut physics, &spec);
            impulse = std::array::from_fn(|axis| impulse[axis] + force[axis] * spec.timestep);
        }
        let momentum = momentum(&mut physics, &spec);
        let weight = 9.81 * spec.total_mass() * 0.4;
        println!(
            "{name}: momentum {momentum:.3?}, impulse {impulse:.3?}, of the weight {weight:.3}"
        );
        assert!(impulse[2] > 0.2 * weight, "{name} touches nothing");
        assert!(
            worst(&momentum, &[impulse[0], impulse[1], impulse[2] - weight]) < 0.02 * weight,
            "{name}"
        );
    }
}

fn momentum(physics: &mut Rapier, spec: &copq_envs::RobotSpec) -> [f64; 3] {
    let mut velocities = vec![0.0; 6 * spec.bodies.len()];
    let mut inertias = vec![0.0; 10 * spec.bodies.len()];
    physics.read(Field::Velocity, &mut velocities).unwrap();
    physics.read(Field::Inertia, &mut inertias).unwrap();
    // Velocities are at the robot's centre of mass; the moments of mass about it turn with each
    // body.
    let rows = velocities.chunks(6).zip(inertias.chunks(10));
    rows.fold([0.0; 3], |sum, (velocity, inertia)| {
        let spin = [velocity[0], velocity[1], velocity[2]];
        let arm = [inertia[6], inertia[7], inertia[8]];
        let swing = [
            spin[1] * arm[2] - spin[2] * arm[1],
            spin[2] * arm[0] - spin[0] * arm[2],
            spin[0] * arm[1] - spin[1] * arm[0],
        ];
        std::array::from_fn(|axis| sum[axis] + inertia[9] * velocity[3 + axis] + swing[axis])
    })
}

fn total(physics: &mut Rapier, spec: &copq_envs::RobotSpec) -> [f64; 3] {
    let mut forces = vec![0.0; 6 * spec.bodies.len()];
    physics.read(Field::ContactForce, &mut forces).unwrap();
    forces
        .chunks(6)
        .fold([0.0; 3], |sum, row| std::array::from_fn(|axis| sum[axis] + row[3 + axis]))
}
