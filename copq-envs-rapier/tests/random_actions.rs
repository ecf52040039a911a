//! Random actions: always finite, and falling as soon as in MuJoCo.

mod support;

use support::Walk;

#[test]
fn the_contract_of_environments_is_kept() {
    let report = copq::check_env(&mut *copq_envs_rapier::make("a/hopper").unwrap()).unwrap();
    assert_eq!(report.reward_range[0], (0.0, 1.0), "{report:?}");
}

#[test]
fn ten_seeds_of_a_thousand_steps_stay_finite() {
    for seed in 0..10 {
        let mut walk = Walk::new(copq_envs_rapier::make("a/hopper").unwrap(), seed);
        for _ in 0..1000 {
            walk.step();
            assert!(walk.obs.iter().chain(&walk.reward).all(|value| value.is_finite()), "seed {seed}");
        }
    }
}

/// Over 2,000 episodes: 21.4 on rapier, 22.7 on MuJoCo 3.17.0 (standard errors 0.3).
#[test]
fn random_episodes_last_as_long_as_measured() {
    let mut walk = Walk::new(copq_envs_rapier::make("a/hopper").unwrap(), 1);
    while walk.lengths.len() < 400 {
        walk.step();
    }
    let mean = walk.lengths.iter().sum::<usize>() as f64 / walk.lengths.len() as f64;
    println!("mean length of a random episode: {mean}");
    assert!((19.0..24.0).contains(&mean), "{mean}");
}

/// `cargo test --release -p copq-envs-rapier -- --ignored --nocapture speed`
#[test]
#[ignore = "prints a speed, checks nothing"]
fn speed() {
    let mut walk = Walk::new(copq_envs_rapier::make("a/hopper").unwrap(), 1);
    let start = std::time::Instant::now();
    let steps = 20_000;
    (0..steps).for_each(|_| {
        walk.step();
    });
    println!("{:.0} environment steps/s, resets included", f64::from(steps) / start.elapsed().as_secs_f64());
}
