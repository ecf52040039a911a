//! A step allocates nothing on our side, contact forces and all: counted by the allocator itself.

use crate::support::ENGINES;
use copq::Env;
use copq_envs::robot::{Preset, Senses};
use copq_envs::{Locomotion, Options, task_with};

#[test]
fn a_step_allocates_nothing() {
    // Two integrators, every field, and damping by hand where MuJoCo has none.
    for (name, preset) in
        [("gym/humanoid", Preset::GymV5), ("gym/ant", Preset::GymV5), ("a/humanoid", Preset::Paper)]
    {
        for make in ENGINES {
            let options = Options { preset, senses: Senses::Gymnasium, ..Options::default() };
            let task = task_with(name, &options).unwrap();
            let physics = make(&task.robot).unwrap();
            let mut env = Locomotion::new(task, physics).unwrap();
            let mut obs = vec![0.0; env.spec().obs_len];
            let mut reward = vec![0.0; env.spec().objectives.len()];
            let action = vec![0.1; env.spec().action_len()];
            env.reset(1, &mut obs).unwrap();
            let steps = || {
                for _ in 0..10 {
                    env.step(&action, &mut obs, &mut reward).unwrap();
                }
            };
            assert_eq!(allocation_counter::measure(steps).count_total, 0, "{name}");
        }
    }
}
