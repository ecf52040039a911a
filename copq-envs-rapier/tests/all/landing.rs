//! What falls on the floor goes in so far and no further, and is not thrown back, whatever the
//! timestep.

use crate::support;

use approx::assert_abs_diff_eq;
use copq_envs::robot::{Joint, Preset};
use copq_envs::{Physics, RobotSpec};
use copq_envs_rapier::Rapier;
use support::parts::{ball, block, contraption, floor};
use support::{qpos, qvel, robot};

/// A ball of 2 kg and 0.1 m on its way down.
fn falling(timestep: f64) -> RobotSpec {
    let mut spec =
        contraption(vec![block("ball", None)], vec![Joint::slide("z", 0, [0.0, 0.0, 1.0])]);
    spec.geoms = vec![ball(Some(0), 0.1), floor(0.0)];
    spec.timestep = timestep;
    spec
}

/// MuJoCo 3.17.0 with Euler's method: 30.3, 30.8 and 41.0 mm in, 0.55, 0.57 and 1.00 m/s out; with
/// Runge-Kutta's in the timestep of 0.01 s 34.8 mm and 0.62 m/s.
#[test]
fn a_ball_goes_in_and_comes_out_as_in_mujoco() {
    for (timestep, depth, speed) in
        [(0.002, 0.0303, 0.55), (0.003, 0.0308, 0.57), (0.01, 0.041, 0.8)]
    {
        let mut physics = Rapier::new(&falling(timestep)).unwrap();
        physics.reset_to(&[0.1], &[-4.0]).unwrap();
        let mut deepest = 0.0_f64;
        let mut fastest = 0.0_f64;
        for _ in 0..(0.5 / timestep) as usize {
            physics.step(&[], 1).unwrap();
            (deepest, fastest) =
                (deepest.max(0.1 - qpos(&physics)[0]), fastest.max(qvel(&physics)[0]));
        }
        println!("{timestep}: {deepest} m, {fastest} m/s");
        assert_abs_diff_eq!(deepest / depth, 1.0, epsilon = 0.15);
        assert_abs_diff_eq!(fastest / speed, 1.0, epsilon = 0.05);
    }
}

/// It starts with its ankles half a radian outside their limits, falls on its feet and is pushed up
/// by them: in MuJoCo to 0.774 m, with either method and in timesteps down to 0.001 s.
#[test]
fn an_idle_ant_is_not_thrown_into_the_air() {
    let spec = robot("ant", Preset::GymV5);
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&spec.initial_qpos, &vec![0.0; spec.nv()]).unwrap();
    let highest = (0..200).fold(0.0_f64, |highest, _| {
        physics.step(&[0.0; 8], 1).unwrap();
        highest.max(qpos(&physics)[2])
    });
    assert_abs_diff_eq!(highest, 0.774, epsilon = 0.01);
}
