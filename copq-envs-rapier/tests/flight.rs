//! Contact-free motion against MuJoCo's (Runge-Kutta) over 40 steps, 0.32 s, of random torques 20 m above the floor.

mod support;

use copq_envs::robot::Preset;
use copq_envs::{Physics, robot};
use copq_envs_rapier::Rapier;
use support::Table;

/// Steps before a joint first strikes its limit (the leg, at 0).
const FREE: usize = 14;

/// Largest errors: height and x of the centre of mass (m), any entry of qpos before and after limits act (m, rad).
#[derive(Debug, Default)]
struct Worst {
    fall: f64,
    drift: f64,
    free: f64,
    limited: f64,
}

fn fly() -> Worst {
    let golden = Table::parse(include_str!("data/hopper_flight.csv"));
    let spec = robot::hopper(Preset::GymV5);
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&golden.vector(0, "qpos"), &golden.vector(0, "qvel")).unwrap();
    let start = physics.centre_of_mass().unwrap();
    let mut worst = Worst::default();
    for row in 1..golden.len() {
        physics.step(&golden.vector(row, "u"), spec.frame_skip).unwrap();
        let centre = physics.centre_of_mass().unwrap();
        let t = row as f64 * spec.dt();
        // Semi-implicit steps sum to g t (t + timestep) / 2.
        let fallen = 0.5 * 9.81 * t * (t + spec.timestep);
        raise(&mut worst.fall, centre[2] - (start[2] - fallen));
        raise(&mut worst.drift, centre[0] - start[0]);
        raise(&mut worst.drift, centre[1]);
        let mut qpos = [0.0; 6];
        physics.qpos(&mut qpos);
        let error = if row <= FREE { &mut worst.free } else { &mut worst.limited };
        qpos.iter().zip(golden.vector(row, "qpos")).for_each(|(got, wanted)| raise(error, got - wanted));
    }
    worst
}

fn raise(worst: &mut f64, error: f64) {
    assert!(error.is_finite());
    *worst = worst.max(error.abs());
}

/// The centre of mass keeps the laws of motion; joints agree as far as a first-order method can, limits as far as two
/// kinds of softness can. Measured: 3.2e-5, 5.9e-6, 1.4e-3, 4.2e-2.
#[test]
fn the_hopper_flies_as_in_mujoco() {
    let worst = fly();
    println!("{worst:?}");
    assert!(worst.fall < 1e-4 && worst.drift < 2e-5, "{worst:?}");
    assert!(worst.free < 2e-3 && worst.limited < 5e-2, "{worst:?}");
}

#[test]
fn the_centre_of_mass_starts_where_mujoco_has_it() {
    let golden = Table::parse(include_str!("data/hopper_flight.csv"));
    let mut physics = Rapier::new(&robot::hopper(Preset::GymV5)).unwrap();
    physics.reset_to(&golden.vector(0, "qpos"), &golden.vector(0, "qvel")).unwrap();
    let centre = physics.centre_of_mass().unwrap();
    for (got, name) in centre.iter().zip(["comx", "comy", "comz"]) {
        assert!((got - golden.get(0, name)).abs() < 1e-12, "{name}: {got}");
    }
}
