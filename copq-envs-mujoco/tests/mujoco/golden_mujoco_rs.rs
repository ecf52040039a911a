//! MuJoCo 3.17.0 against Gymnasium v5, and against the paper's preset, recorded on the same
//! library.

use crate::support::{
    BENCHMARKS, ROBOTS, Replay, close, golden, observation, one_steps, rewards, rollout,
    rollout_errors, state_error, task,
};
use copq::Outcome;
use copq_envs::robot::Preset;
use copq_envs_mujoco::mujoco_rs::physics;

#[test]
fn every_bit_of_a_rollout_is_gymnasiums() {
    for robot in ROBOTS {
        let task = task(&format!("gym/{robot}"), Preset::GymV5);
        let table = golden(&format!("{robot}_rollout"));
        let start = [table.vector(0, "qpos"), table.vector(0, "qvel")];
        rollout(physics, &task.robot, &table, [&start[0], &start[1]], |physics, row| {
            assert_eq!(
                state_error(physics, &table, row, ["qpos", "qvel"]),
                0.0,
                "{robot}, row {row}"
            );
            assert_eq!(observation(physics, &task), table.vector(row, "obs"), "{robot}, row {row}");
        });
        println!("{robot}: {} steps without a difference", table.len() - 1);
    }
}

#[test]
fn every_bit_of_a_single_step_is_gymnasiums() {
    for robot in ROBOTS {
        let task = task(&format!("gym/{robot}"), Preset::GymV5);
        let table = golden(&format!("{robot}_onestep"));
        one_steps(physics, &task.robot, &table, |physics, row| {
            assert_eq!(
                state_error(physics, &table, row, ["nqpos", "nqvel"]),
                0.0,
                "{robot}, row {row}"
            );
            assert_eq!(observation(physics, &task), table.vector(row, "obs"), "{robot}, row {row}");
        });
        println!("{robot}: {} single steps without a difference", table.len());
    }
}

/// Environments speak f32: the nearest to what was recorded.
#[test]
fn environments_are_gymnasiums() {
    for (benchmark, robot) in BENCHMARKS {
        let task = task(&format!("{benchmark}/{robot}"), Preset::GymV5);
        let table = golden(&format!("{robot}_rollout"));
        let mut replay = Replay::new(physics, &task, &table, 0);
        for row in 1..table.len() {
            let what = format!("{benchmark}/{robot}, row {row}");
            let outcome = replay.step(&table, row);
            assert_eq!(replay.reward, rewards(benchmark, robot, &table, row), "{what}");
            let wanted: Vec<_> =
                table.vector(row, "obs").iter().map(|&value| value as f32).collect();
            assert_eq!(replay.obs, wanted, "{what}");
            assert_eq!(
                outcome == Outcome::Terminated,
                table.get(row, "terminated") == Some(1.0),
                "{what}"
            );
        }
    }
}

#[test]
fn single_steps_earn_gymnasiums_rewards() {
    for robot in ROBOTS {
        let task = task(&format!("gym/{robot}"), Preset::GymV5);
        let table = golden(&format!("{robot}_onestep"));
        for row in 0..table.len() {
            let mut replay = Replay::new(physics, &task, &table, row);
            let outcome = replay.step(&table, row);
            assert_eq!(replay.reward, rewards("gym", robot, &table, row), "{robot}, row {row}");
            assert_eq!(
                outcome == Outcome::Terminated,
                table.get(row, "terminated") == Some(1.0),
                "{robot}, row {row}"
            );
        }
    }
}

/// The recording's robots are Brax's own models, whose numbers differ from ours in the last digit
/// for two robots.
#[test]
fn the_papers_preset() {
    for (benchmark, robot) in BENCHMARKS.into_iter().filter(|(benchmark, _)| *benchmark != "gym") {
        let (task, table) = (
            task(&format!("{benchmark}/{robot}"), Preset::Paper),
            golden(&format!("paper_{robot}_rollout")),
        );
        let errors = rollout_errors(physics, &task.robot, &table);
        println!(
            "{robot} of the paper: off by {:e} after {} steps",
            errors[errors.len() - 1],
            errors.len() - 1
        );
        assert!(errors[..=50].iter().all(|&error| error < 1e-11), "{robot}: {errors:?}");
        let mut replay = Replay::new(physics, &task, &table, 0);
        for row in 1..=50 {
            let what = format!("{benchmark}/{robot}, row {row}");
            let outcome = replay.step(&table, row);
            close(&replay.reward, &rewards(benchmark, robot, &table, row), 1e-6, &what);
            close(&replay.obs, &table.vector(row, "obs"), 1e-6, &what);
            assert_eq!(
                outcome == Outcome::Terminated,
                table.get(row, "terminated") == Some(1.0),
                "{what}"
            );
        }
    }
}
