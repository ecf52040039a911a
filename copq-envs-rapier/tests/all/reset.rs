//! A reset leaves nothing of the episode before.

use crate::support;

use copq::Rng;
use copq_envs::robot::Preset;
use copq_envs::{Field, Physics, RobotSpec};
use copq_envs_rapier::Rapier;
use support::{ROBOTS, controls, qpos, qvel, robot};

/// The bits of every state and contact force of some environment steps under these random actions.
fn play(physics: &mut Rapier, spec: &RobotSpec, seed: u64) -> Vec<u64> {
    let mut rng = Rng::with_stream(seed, 97);
    let mut bits = Vec::new();
    let mut forces = vec![0.0; 6 * spec.bodies.len()];
    for _ in 0..40 {
        let actions: Vec<_> = (0..spec.nu()).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        physics.step(&controls(spec, &actions), spec.frame_skip).unwrap();
        physics.read(Field::ContactForce, &mut forces).unwrap();
        bits.extend(
            [qpos(physics), qvel(physics), forces.clone()].concat().into_iter().map(f64::to_bits),
        );
    }
    bits
}

#[test]
fn an_engine_that_was_used_goes_on_like_a_new_one() {
    for name in ROBOTS {
        let spec = robot(name, Preset::GymV5);
        let mut used = Rapier::new(&spec).unwrap();
        for seed in 0..3 {
            let velocity: Vec<_> =
                (0..spec.nv()).map(|freedom| 0.1 * (freedom as f64 - seed as f64)).collect();
            let mut new = Rapier::new(&spec).unwrap();
            for physics in [&mut used, &mut new] {
                physics.reset_to(&spec.initial_qpos, &velocity).unwrap();
            }
            assert!(
                play(&mut used, &spec, seed) == play(&mut new, &spec, seed),
                "{name} after {seed} episodes"
            );
        }
    }
}
