//! What every locomotion environment promises, on an engine by hand.

use crate::support;
use approx::assert_abs_diff_eq;

use copq::{Env, Outcome, State};
use copq_envs::task::Signal;
use copq_envs::{Locomotion, task, tasks};
use support::Still;

/// An environment with its buffers.
struct Bench {
    env: Locomotion<Still>,
    obs: Vec<f32>,
    reward: Vec<f32>,
}

impl Bench {
    fn new(physics: Still) -> Self {
        let env = Locomotion::new(task("a/hopper").unwrap(), physics).unwrap();
        Self { env, obs: vec![0.0; 11], reward: vec![0.0; 3] }
    }

    fn reset(&mut self, seed: u64) {
        self.env.reset(seed, &mut self.obs).unwrap();
    }

    fn step(&mut self, action: [f32; 3]) -> copq::Result<Outcome> {
        self.env.step(&action, &mut self.obs, &mut self.reward)
    }

    /// Steps with no action until the episode ends; its length and outcome.
    fn run(&mut self) -> (usize, Outcome) {
        (1..)
            .map(|step| (step, self.step([0.0; 3]).unwrap()))
            .find(|(_, outcome)| *outcome != Outcome::Running)
            .unwrap()
    }
}

#[test]
fn the_description_is_benchmark_as() {
    let bench = Bench::new(Still::new());
    let spec = bench.env.spec();
    assert_eq!((spec.name.as_str(), spec.obs_len, spec.horizon), ("a/hopper", 11, 1000));
    assert_eq!((&spec.action_low, &spec.action_high), (&vec![-1.0; 3], &vec![1.0; 3]));
    assert_eq!(spec.names(), ["safety", "velocity", "control"]);
    assert_eq!(spec.weights(), [1.0, 1.0, 1.0]);
}

#[test]
fn a_healthy_episode_is_truncated_at_exactly_a_thousand_steps() {
    let mut bench = Bench::new(Still::new());
    bench.reset(1);
    assert_eq!(bench.run(), (1000, Outcome::Truncated));
    assert_eq!(bench.reward[0], 1.0);
    let error = bench.step([0.0; 3]).unwrap_err().to_string();
    assert!(error.contains("a/hopper") && error.contains("ended at step 1000"), "{error}");
    bench.reset(2);
    assert_eq!(bench.step([0.0; 3]).unwrap(), Outcome::Running);
}

#[test]
fn falling_terminates_on_the_last_step_too() {
    for fall in [1, 37, 1000] {
        let mut bench = Bench::new(Still::falling(fall, 0.6));
        bench.reset(1);
        assert_eq!(bench.run(), (fall, Outcome::Terminated));
        assert_eq!(bench.reward[0], 0.0);
    }
}

#[test]
fn noise_depends_on_the_seed_alone_and_stays_in_its_bounds() {
    let mut one = Bench::new(Still::new());
    let mut other = Bench::new(Still::new());
    one.reset(5);
    one.step([1.0; 3]).unwrap();
    one.reset(7);
    other.reset(7);
    assert_eq!(one.obs, other.obs);
    other.reset(8);
    assert_ne!(one.obs, other.obs);
    for seed in 0..200 {
        one.reset(seed);
        assert!((one.obs[0] - 1.25).abs() <= 0.005_001);
        assert!(one.obs[1..].iter().all(|value| value.abs() <= 0.005_001 && *value != 0.0));
    }
}

#[test]
fn actions_are_clamped_for_the_motors_and_for_the_cost() {
    let mut bench = Bench::new(Still::new());
    bench.reset(1);
    bench.step([0.5, -3.0, 2.0]).unwrap();
    assert_eq!(bench.env.physics().ctrl, [0.5, -1.0, 1.0]);
    assert_eq!(bench.reward[2], -2.25);
    // Four substeps of 0.5 in 0.008 s.
    assert_abs_diff_eq!(bench.reward[1], 250.0, epsilon = 1e-3);
}

#[test]
fn velocities_are_clipped_in_the_observation() {
    let mut bench = Bench::new(Still::new());
    bench.reset(1);
    let mut state = State::default();
    bench.env.save(&mut state).unwrap();
    state.child_mut("physics").put("qvel", vec![50.0, -50.0, 3.0, 0.0, 0.0, 0.0]);
    bench.env.load(&state).unwrap();
    bench.step([0.0; 3]).unwrap();
    assert_eq!(bench.obs[5..8], [10.0, -10.0, 3.0]);
}

#[test]
fn misuse_is_an_error_and_not_a_panic() {
    let mut bench = Bench::new(Still::new());
    assert!(bench.step([0.0; 3]).unwrap_err().to_string().contains("before the first reset"));
    bench.reset(1);
    let error = bench.step([0.0, f32::NAN, 0.0]).unwrap_err().to_string();
    assert!(error.contains("action[1] is NaN"), "{error}");
    assert!(bench.env.step(&[0.0; 2], &mut bench.obs, &mut bench.reward).is_err());
    assert!(bench.env.step(&[0.0; 3], &mut [0.0; 10], &mut bench.reward).is_err());
    assert!(bench.env.step(&[0.0; 3], &mut bench.obs, &mut [0.0; 2]).is_err());
    assert!(bench.env.reset(1, &mut [0.0; 10]).is_err());
    assert_eq!(bench.step([0.0; 3]).unwrap(), Outcome::Running);
}

#[test]
fn a_state_that_is_not_finite_is_an_error_until_the_next_reset() {
    let mut bench = Bench::new(Still::falling(3, f64::NAN));
    bench.reset(1);
    bench.step([0.0; 3]).unwrap();
    bench.step([0.0; 3]).unwrap();
    let error = bench.step([0.0; 3]).unwrap_err();
    assert!(matches!(error, copq::Error::Env { .. }));
    assert!(error.to_string().contains("not finite after step 3"), "{error}");
    assert!(bench.step([0.0; 3]).is_err());
}

#[test]
fn a_saved_episode_keeps_its_clock_and_its_end() {
    let mut bench = Bench::new(Still::new());
    bench.reset(1);
    (0..990).for_each(|_| assert_eq!(bench.step([0.0; 3]).unwrap(), Outcome::Running));
    let mut state = State::default();
    bench.env.save(&mut state).unwrap();
    let mut other = Bench::new(Still::new());
    other.env.load(&state).unwrap();
    assert_eq!(other.run(), (10, Outcome::Truncated));
    other.env.save(&mut state).unwrap();
    bench.env.load(&state).unwrap();
    assert!(bench.step([0.0; 3]).unwrap_err().to_string().contains("ended"));
}

#[test]
fn an_engine_of_the_wrong_size_is_refused() {
    let mut physics = Still::new();
    physics.dims.nu = 2;
    let error = Locomotion::new(task("a/hopper").unwrap(), physics).unwrap_err().to_string();
    assert!(error.contains("a/hopper on still") && error.contains("nu: 3"), "{error}");
}

#[test]
fn an_unknown_task_is_answered_with_the_nearest() {
    assert!(tasks().contains(&"a/hopper"));
    let error = task("hopper").unwrap_err().to_string();
    assert!(error.contains("'hopper'") && error.contains("a/hopper"), "{error}");
}

#[test]
fn a_task_that_cannot_be_computed_is_refused() {
    let contact = |clip, cap| Signal::Contact { clip, cap };
    for (factor, signal, wanted) in [
        (f64::NAN, Signal::Alive, "finite factors"),
        (1.0, contact(-1.0, 1.0), "a clip and a cap of 0 or more"),
        (1.0, contact(f64::NAN, 1.0), "a clip and a cap of 0 or more"),
        (1.0, contact(1.0, f64::NAN), "a clip and a cap of 0 or more"),
    ] {
        let mut task = copq_envs::task("a/hopper").unwrap();
        task.objectives[0].terms = vec![(factor, signal)];
        let error = Locomotion::new(task, Still::new()).unwrap_err().to_string();
        let begin = format!("objective 'safety': wanted {wanted}, got ");
        assert!(error.starts_with(&begin), "{error}");
    }
}
