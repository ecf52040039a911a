//! Random actions: always finite, and falling as soon as in MuJoCo.

use crate::support;

use approx::assert_abs_diff_eq;
use copq_envs::robot::Preset;
use copq_envs::{Locomotion, Options, task, tasks};
use copq_envs_rapier::{Rapier, make_with};
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
fn lengths(robot: &str, preset: Preset) -> Vec<usize> {
    let options = Options { preset, ..Options::default() };
    let mut lengths = Vec::new();
    for seed in 0..10 {
        let mut walk = Walk::new(make_with(&format!("gym/{robot}"), &options).unwrap(), seed);
        assert!(stays_finite(&mut walk, 1000), "{robot} seed {seed}");
        lengths.append(&mut walk.lengths);
        lengths.extend(Some(walk.length).filter(|&length| length > 0));
    }
    lengths.sort_unstable();
    lengths
}

/// The standard error of the mean of these 400 to 500 episodes is 3 % at most.
fn last(robot: &str, wanted: [f64; 2]) {
    for (preset, wanted) in [Preset::GymV5, Preset::Paper].into_iter().zip(wanted) {
        let lengths = lengths(robot, preset);
        let mean = lengths.iter().sum::<usize>() as f64 / lengths.len() as f64;
        println!("{robot} {preset:?}: {mean:.2} steps, in MuJoCo {wanted}");
        assert_abs_diff_eq!(mean / wanted, 1.0, epsilon = 0.1);
    }
}

// MuJoCo 3.17.0 over 2,000 episodes and more each: standard errors 0.3 at most. Gymnasium 1.4.0's
// robots, then Brax's.
#[test]
fn hoppers_fall_as_soon_as_in_mujoco() {
    last("hopper", [22.1, 21.7]);
}

#[test]
fn walkers_fall_as_soon_as_in_mujoco() {
    last("walker2d", [21.0, 20.9]);
}

#[test]
fn humanoids_fall_as_soon_as_in_mujoco() {
    last("humanoid", [24.7, 24.2]);
}

#[test]
fn halfcheetahs_never_fall() {
    assert_eq!(lengths("halfcheetah", Preset::GymV5), [1000; 10]);
}

fn quartiles_of_ants(preset: Preset) -> [usize; 3] {
    let lengths = lengths("ant", preset);
    let quartiles = [1, 2, 3].map(|quarter| lengths[quarter * lengths.len() / 4]);
    println!("ant {preset:?}: {quartiles:?} of {}", lengths.len());
    quartiles
}

/// Some ants come to lie on their backs and stay till the end, so means say little. MuJoCo's
/// quartiles over 150 episodes: 32 to 46, 65 to 83 and 125 to 163, by the length of the timestep.
#[test]
fn ants_jump_out_of_bounds_as_soon_as_in_mujoco() {
    let [first, middle, _] = quartiles_of_ants(Preset::GymV5);
    assert!((15..46).contains(&first) && (32..83).contains(&middle), "{first} {middle}");
}

/// Brax's ant falls later than in MuJoCo in its own timestep of 0.01 s, and sooner than in shorter
/// ones. MuJoCo's quartiles over 1,359 episodes are 19, 34 and 59 (mean 44), and over 110 each in
/// timesteps of 0.005, 0.0025 and 0.001 s 37 to 50, 58 to 81 and 119 to 125 (means 86 to 95;
/// rapier's 83 to 93).
#[test]
fn ants_of_braxs_fall_between_mujocos_of_long_and_of_short_timesteps() {
    let [first, middle, last] = quartiles_of_ants(Preset::Paper);
    let quartiles = format!("{first} {middle} {last}");
    assert!((19..50).contains(&first) && (34..81).contains(&middle), "{quartiles}");
    assert!((59..125).contains(&last), "{quartiles}");
}
