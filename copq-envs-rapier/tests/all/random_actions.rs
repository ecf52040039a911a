//! Random actions: always finite, and falling as soon as in MuJoCo.

use crate::support;

use approx::assert_abs_diff_eq;
use copq_envs::robot::Preset;
use copq_envs::{Locomotion, Options, task, tasks};
use copq_envs_rapier::{Rapier, make, make_with};
use support::{ROBOTS, Walk};

#[test]
fn every_task_keeps_the_contract_of_environments() {
    for name in tasks() {
        // Long episodes show no more than short ones here.
        let task = copq_envs::Task { horizon: 100, ..task(name).unwrap() };
        let physics = Rapier::new(&task.robot).unwrap();
        let report = copq::check_env(&mut Locomotion::new(task, physics).unwrap()).unwrap();
        assert!(
            report.reward_range.iter().all(|(low, high)| low.is_finite() && high.is_finite()),
            "{name}: {report:?}"
        );
    }
}

#[test]
fn the_papers_robots_stay_finite() {
    let paper = Options { preset: Preset::Paper, ..Options::default() };
    for robot in ROBOTS {
        let mut walk = Walk::new(make_with(&format!("a/{robot}"), &paper).unwrap(), 0);
        assert!(stays_finite(&mut walk, 200), "{robot}");
    }
}

fn stays_finite(walk: &mut Walk, steps: usize) -> bool {
    (0..steps).all(|_| {
        walk.step();
        walk.obs.iter().chain(&walk.reward).all(|value| value.is_finite())
    })
}

/// Ten seeds of a thousand steps, all finite; the lengths of the episodes, in order, unfinished
/// ones as far as they went.
fn lengths(robot: &str) -> Vec<usize> {
    let mut lengths = Vec::new();
    for seed in 0..10 {
        let mut walk = Walk::new(make(&format!("gym/{robot}")).unwrap(), seed);
        assert!(stays_finite(&mut walk, 1000), "{robot} seed {seed}");
        lengths.append(&mut walk.lengths);
        lengths.extend(Some(walk.length).filter(|&length| length > 0));
    }
    lengths.sort_unstable();
    lengths
}

/// The standard error of the mean of these 400 to 500 episodes is 3 % at most.
fn lasts(robot: &str, wanted: f64) {
    let lengths = lengths(robot);
    let mean = lengths.iter().sum::<usize>() as f64 / lengths.len() as f64;
    println!("{robot}: {mean:.2} steps, in MuJoCo {wanted}");
    assert_abs_diff_eq!(mean / wanted, 1.0, epsilon = 0.1);
}

// MuJoCo 3.17.0 and Gymnasium 1.4.0 over 2,000 episodes each: standard errors 0.3, 0.2 and 0.2.
#[test]
fn hoppers_fall_as_soon_as_in_mujoco() {
    lasts("hopper", 22.1);
}

#[test]
fn walkers_fall_as_soon_as_in_mujoco() {
    lasts("walker2d", 21.0);
}

#[test]
fn humanoids_fall_as_soon_as_in_mujoco() {
    lasts("humanoid", 24.7);
}

#[test]
fn halfcheetahs_never_fall() {
    assert_eq!(lengths("halfcheetah"), [1000; 10]);
}

/// Some ants come to lie on their backs and stay till the end, so means say little. MuJoCo's
/// quartiles over 150 episodes: 32 to 46, 65 to 83 and 125 to 163, by the length of the timestep.
#[test]
fn ants_jump_out_of_bounds_as_soon_as_in_mujoco() {
    let lengths = lengths("ant");
    let quartiles = [1, 2, 3].map(|quarter| lengths[quarter * lengths.len() / 4]);
    println!("{quartiles:?} of {}", lengths.len());
    assert!((15..46).contains(&quartiles[0]) && (32..83).contains(&quartiles[1]), "{quartiles:?}");
}
