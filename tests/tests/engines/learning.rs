//! On-policy learners learn as OmniSafe's do, on the hopper whose speed costs, with a limit of 20
//! that bites at once.

#![cfg(feature = "mujoco-rs")]

use copq::on_policy::{Learner, Method, Saute};
use copq::{AdjustedEnv, Env, Observer, Trainer};
use copq_candle::Candle;
use copq_envs_mujoco::mujoco_rs::make;

/// What an epoch came to: means over its episodes, and the multiplier.
#[derive(Debug, Default)]
struct Epoch {
    episodes: f64,
    reward: f64,
    cost: f64,
    length: f64,
    multiplier: f64,
}

/// Epochs of 2,048 steps, the step size falling over twenty of them.
fn learn(name: &str, seed: u64, epochs: usize) -> Vec<Epoch> {
    let mut method = Method::by_name(name).unwrap();
    method.config.anneal_steps = Some(20 * 2_048);
    method.config.window = 100;
    let world = AdjustedEnv::new(make("b/hopper").unwrap()).limits([("cost", 20.0)]).unwrap();
    let env: Box<dyn Env> = match &method.config.saute {
        Some(saute) => Box::new(Saute::new(world, saute).unwrap()),
        None => Box::new(world),
    };
    let learner = Learner::new(method, env.spec(), &Candle::default(), seed).unwrap();
    let mut trainer = Trainer::new(env, learner).unwrap();
    let mut log = Multiplier::default();
    let epoch = |_| {
        let mut epoch = Epoch::default();
        let done = trainer.agent().epochs();
        while trainer.agent().epochs() == done {
            for episode in trainer.step(&mut log).unwrap() {
                epoch.episodes += 1.0;
                epoch.cost += episode.returns[0];
                epoch.reward += episode.returns[1];
                epoch.length += episode.length as f64;
            }
        }
        for sum in [&mut epoch.cost, &mut epoch.reward, &mut epoch.length] {
            *sum /= epoch.episodes;
        }
        epoch.multiplier = log.0;
        epoch
    };
    (0..epochs).map(epoch).collect()
}

/// The last multiplier reported.
#[derive(Default)]
struct Multiplier(f64);

impl Observer for Multiplier {
    fn scalar(&mut self, _: u64, name: &str, value: f64) {
        if name == "multiplier/cost" {
            self.0 = value;
        }
    }
}

#[test]
fn ppo_learns_and_ppo_lag_is_ppo_until_its_limit_is_passed() {
    let ppo = learn("ppo", 0, 10);
    assert!((8.0..16.0).contains(&ppo[0].reward) && (14.0..22.0).contains(&ppo[0].length));
    assert!(ppo[9].reward > 150.0 && ppo[9].cost > 80.0, "{ppo:?}");
    let lag = learn("ppo-lag", 0, 10);
    let free = lag.iter().position(|epoch| epoch.multiplier > 0.0).unwrap();
    assert!(free > 3);
    // An epoch's steps are those of the policy before its multiplier.
    for (ppo, lag) in ppo.iter().zip(&lag).take(free + 1) {
        assert_eq!((ppo.reward, ppo.cost, ppo.length), (lag.reward, lag.cost, lag.length));
    }
    assert!(lag[9].reward != ppo[9].reward);
    for pair in lag[free..].windows(2) {
        let rise = pair[1].multiplier - pair[0].multiplier;
        assert!((0.01..0.05).contains(&rise), "{rise}");
    }
}

#[test]
fn saute_lengthens_its_episodes_under_the_budget() {
    let saute = learn("ppo-saute", 0, 14);
    let last = &saute[13];
    assert!(last.cost < 25.0 && last.length > 100.0, "{last:?}");
}

#[test]
fn cups_second_step_and_rcpos_multiplier_bring_costs_down() {
    let cup = learn("cup", 0, 16);
    assert!(cup.iter().all(|epoch| epoch.cost < 90.0) && cup[15].cost < 30.0, "{cup:?}");
    let rcpo = learn("rcpo", 0, 16);
    let peak = rcpo.iter().map(|epoch| epoch.cost).fold(0.0, f64::max);
    assert!(peak > 60.0 && rcpo[15].cost < 0.5 * peak, "{rcpo:?}");
}

#[test]
fn pid_answers_at_once() {
    let pid = learn("cppo-pid", 0, 14);
    let peak = pid.iter().map(|epoch| epoch.cost).fold(0.0, f64::max);
    assert!(peak < 100.0 && pid.iter().any(|epoch| epoch.multiplier > 0.1), "{pid:?}");
}
