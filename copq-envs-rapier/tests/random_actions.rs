//! Random actions: always finite, and falling as soon as in MuJoCo.

mod support;

use copq_envs::robot::Preset;
use copq_envs::{Options, tasks};
use copq_envs_rapier::{make, make_with};
use support::{ROBOTS, Walk};

#[test]
fn every_task_keeps_the_contract_of_environments() {
    for name in tasks() {
        let report = copq::check_env(&mut *make(name).unwrap()).unwrap();
        assert!(
            report.reward_range.iter().all(|(low, high)| low.is_finite() && high.is_finite()),
            "{name}: {report:?}"
        );
    }
}

#[test]
fn ten_seeds_of_a_thousand_steps_stay_finite() {
    for robot in ROBOTS {
        for seed in 0..10 {
            let mut walk = Walk::new(make(&format!("a/{robot}")).unwrap(), seed);
            assert!(stays_finite(&mut walk, 1000), "{robot} seed {seed}");
        }
        let paper = Options { preset: Preset::Paper, ..Options::default() };
        let mut walk = Walk::new(make_with(&format!("a/{robot}"), &paper).unwrap(), 0);
        assert!(stays_finite(&mut walk, 1000), "{robot} of the paper");
    }
}

fn stays_finite(walk: &mut Walk, steps: usize) -> bool {
    (0..steps).all(|_| {
        walk.step();
        walk.obs.iter().chain(&walk.reward).all(|value| value.is_finite())
    })
}

/// MuJoCo 3.17.0 and Gymnasium 1.4.0 over 2,000 episodes: 22.1, 21.0 and 24.7 (standard errors 0.3, 0.2, 0.2).
#[test]
fn random_episodes_last_as_long_as_in_mujoco() {
    for (robot, wanted) in [("hopper", 22.1), ("walker2d", 21.0), ("humanoid", 24.7)] {
        let lengths = Walk::new(make(&format!("gym/{robot}")).unwrap(), 1).episodes(200);
        let mean = lengths.iter().sum::<usize>() as f64 / lengths.len() as f64;
        println!("{robot}: {mean:.2} steps, in MuJoCo {wanted}");
        // The standard error of 200 episodes is 4 % at most.
        assert!((mean / wanted - 1.0).abs() < 0.1, "{robot}: {mean}");
    }
}

/// Some ants come to lie on their backs and stay till the end, so means say little. MuJoCo's quartiles over 150 episodes: 32 to
/// 46, 65 to 83 and 125 to 163, by the length of the timestep.
#[test]
fn random_ants_jump_out_of_bounds_as_soon_as_in_mujoco() {
    let lengths = Walk::new(make("gym/ant").unwrap(), 1).episodes(120);
    let quartiles = [30, 60, 90].map(|place| lengths[place]);
    println!("{quartiles:?}");
    assert!((15..46).contains(&quartiles[0]) && (32..83).contains(&quartiles[1]), "{quartiles:?}");
}

/// `cargo test --release -p copq-envs-rapier -- --ignored --nocapture speed`
#[test]
#[ignore = "prints speeds, checks nothing"]
fn speed() {
    for robot in ROBOTS {
        let mut walk = Walk::new(make(&format!("a/{robot}")).unwrap(), 1);
        let start = std::time::Instant::now();
        let steps = 5_000;
        (0..steps).for_each(|_| {
            walk.step();
        });
        println!("{robot}: {:.0} steps/s, resets included", f64::from(steps) / start.elapsed().as_secs_f64());
    }
}
