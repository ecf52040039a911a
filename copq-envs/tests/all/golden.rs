//! Observations, rewards and health against Gymnasium v5's and Brax's, given MuJoCo's states.

use crate::support;

use approx::abs_diff_eq;
use copq::{Env, Outcome};
use copq_envs::robot::{Preset, Senses};
use copq_envs::{Locomotion, Options, Task, task_with};
use support::{Recording, Table};

const PLANAR: [&str; 3] = ["hopper", "walker2d", "halfcheetah"];

fn table(preset: Preset, robot: &str) -> Table {
    let preset = if preset == Preset::GymV5 { "gym" } else { "paper" };
    let file = format!("{}/tests/data/rollout_{preset}_{robot}.csv", env!("CARGO_MANIFEST_DIR"));
    Table::parse(&std::fs::read_to_string(file).unwrap())
}

fn task(name: &str, preset: Preset) -> Task {
    // Gymnasium's whole observation, so that the ant's contact forces are tested too.
    let senses = if preset == Preset::GymV5 { Senses::Gymnasium } else { Senses::Standard };
    task_with(name, &Options { preset, senses, ..Options::default() }).unwrap()
}

/// Plays a robot's recorded run in a task: every observation, the rewards in the columns `rewards`,
/// and the end.
fn replay(benchmark: &str, robot: &str, preset: Preset, rewards: &[&str]) {
    let task = task(&format!("{benchmark}/{robot}"), preset);
    let table = table(preset, robot);
    let physics = Recording::new(&task.robot, &table);
    let mut env = Locomotion::new(task, physics).unwrap();
    let mut obs = vec![0.0; env.spec().obs_len];
    let mut reward = vec![0.0; env.spec().objectives.len()];
    env.reset(0, &mut obs).unwrap();
    close(&obs, &table.vector(0, "obs"), robot);
    for row in 1..table.len() {
        let what = format!("{benchmark}/{robot} {preset:?} row {row}");
        let action: Vec<f32> = table.vector(row, "u").iter().map(|&u| u as f32).collect();
        let outcome = env.step(&action, &mut obs, &mut reward).unwrap();
        close(&obs, &table.vector(row, "obs"), &what);
        let wanted: Vec<_> = rewards.iter().map(|name| table.get(row, name).unwrap()).collect();
        close(&reward, &wanted, &what);
        let ended = table.get(row, "terminated") == Some(1.0);
        assert_eq!(outcome, if ended { Outcome::Terminated } else { Outcome::Running }, "{what}");
        assert!(!ended || row + 1 == table.len());
    }
}

fn close(got: &[f32], wanted: &[f64], what: &str) {
    assert_eq!(got.len(), wanted.len(), "{what}");
    for (i, (&got, &wanted)) in got.iter().zip(wanted).enumerate() {
        let close = abs_diff_eq!(f64::from(got), wanted, epsilon = 1e-6 * (1.0 + wanted.abs()));
        assert!(close, "{what}, number {i}: {got} against {wanted}");
    }
}

#[test]
fn benchmark_a() {
    for preset in [Preset::GymV5, Preset::Paper] {
        for robot in ["hopper", "walker2d", "ant", "humanoid"] {
            replay("a", robot, preset, &["A_safety", "A_velocity", "A_control"]);
        }
        replay("a", "halfcheetah", preset, &["A_velocity", "A_control"]);
    }
}

#[test]
fn benchmark_b() {
    for preset in [Preset::GymV5, Preset::Paper] {
        for robot in ["hopper", "walker2d", "ant", "humanoid"] {
            replay("b", robot, preset, &["B_cost", "B_reward"]);
        }
    }
}

#[test]
fn gymnasiums_own_rewards() {
    for robot in PLANAR.into_iter().chain(["ant", "humanoid"]) {
        replay("gym", robot, Preset::GymV5, &["gym_reward"]);
    }
}
