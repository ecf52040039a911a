//! A step allocates nothing: counted by the allocator itself.

use crate::support;

use copq::Env;
use copq_envs::robot::Preset;
use copq_envs::{Locomotion, Options, task_with};
use support::{Recording, Table};

/// Benchmark A's humanoid of the paper reads the most; Gymnasium's own prices contacts.
#[test]
fn a_step_allocates_nothing() {
    let runs = [
        ("gym/humanoid", Preset::GymV5, include_str!("../data/rollout_gym_humanoid.csv")),
        ("a/humanoid", Preset::Paper, include_str!("../data/rollout_paper_humanoid.csv")),
    ];
    for (name, preset, text) in runs {
        let task = task_with(name, &Options { preset, ..Options::default() }).unwrap();
        let physics = Recording::new(&task.robot, &Table::parse(text));
        let mut env = Locomotion::new(task, physics).unwrap();
        let mut obs = vec![0.0; env.spec().obs_len];
        let mut reward = vec![0.0; env.spec().objectives.len()];
        env.reset(1, &mut obs).unwrap();
        let step = || {
            env.step(&[0.5; 17], &mut obs, &mut reward).unwrap();
        };
        assert_eq!(allocation_counter::measure(step).count_total, 0, "{name}");
    }
}
