//! The learner on a world whose optimum is known, with hand-written linear networks.

use crate::toy;
use approx::{abs_diff_eq, assert_abs_diff_eq};

use copq::*;
use toy::{SLOPE, Toy};

#[test]
fn td3_learns_the_optimum_with_every_projection() {
    for &name in projection::names() {
        let projection = projection::by_name(name).unwrap();
        let critics = toy::critics_of(projection.as_ref());
        let mut trainer =
            toy::trainer(toy::learner(Method::new("toy", toy::config(), projection), critics, 1));
        for _ in 0..3_000 {
            trainer.step(&mut Silent).unwrap();
        }
        let policy = toy::policy(trainer.agent_mut());
        let close = abs_diff_eq!(policy[..], [0.0, SLOPE][..], epsilon = 0.05);
        assert!(close, "{name}: bias and slope {policy:?}, wanted 0 and {SLOPE}");
    }
}

/// -(a - s/2)^2 = -a^2 + a s - s^2/4 at a = s/4 averages -1/48, -1/48; the value adds
/// gamma/(1-gamma) of that.
#[test]
fn values_converge_to_the_discounted_returns() {
    // Without the bound and without smoothing noise, which would both be paid for in the targets.
    let config = Config { pessimism: 0.0, smoothing: None, ..toy::config() };
    let mut trainer = toy::trainer(toy::learner(toy::method(config), 3, 4));
    (0..6_000).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
    let evaluation = evaluate(trainer.agent_mut(), Toy::new(), 200).unwrap();
    let Evaluation { q_start, discounted, .. } = evaluation;
    assert_abs_diff_eq!(q_start[..], discounted[..], epsilon = 0.01);
    assert_abs_diff_eq!(discounted[0], -1.0 / 24.0, epsilon = 0.01);
}

fn run(seed: u64, steps: u64) -> State {
    let mut trainer = toy::trainer(toy::learner(toy::method(toy::config()), 3, seed));
    toy::run(&mut trainer, steps)
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_does_not() {
    assert_eq!(run(3, 400), run(3, 400));
    assert_ne!(run(3, 400), run(4, 400));
}

#[test]
fn what_a_state_held_before_is_not_saved_again() {
    let mut trainer = toy::trainer(toy::learner(toy::method(toy::config()), 3, 3));
    trainer.run(413, &mut Silent).unwrap();
    let mut state = State::default();
    trainer.save(&mut state).unwrap();
    assert!(state.child("env").is_ok(), "in mid-episode");
    // An episode has 20 steps.
    trainer.run(7, &mut Silent).unwrap();
    trainer.save(&mut state).unwrap();
    assert!(state == run(3, 420) && state.child("env").is_err());
    trainer.run(3, &mut Silent).unwrap();
    trainer.save(&mut state).unwrap();
    trainer.save_without_episodes(&mut state).unwrap();
    assert!(state.child("env").is_err());
}

#[test]
fn a_resumed_run_is_the_same_bit_for_bit() {
    // 413 is in mid-episode, and after the warm-up; the ring of 5,000 is not full, 5,200 steps
    // later it is.
    for (first, total) in [(113, 500), (413, 800), (5_213, 5_500)] {
        let mut resumed = toy::trainer(toy::learner(toy::method(toy::config()), 3, 3));
        resumed.run(77, &mut Silent).unwrap();
        resumed.load(&run(3, first)).unwrap();
        let state = toy::run(&mut resumed, total);
        assert!(state == run(3, total), "{first} + {} steps", total - first);
    }
}

#[test]
fn optimistic_exploration_resumes_bit_for_bit() {
    let fresh =
        || toy::trainer(toy::learner(toy::method(toy::small(Method::cop_td3_oac().config)), 3, 77));
    let mut resumed = fresh();
    resumed.load(&toy::run(&mut fresh(), 413)).unwrap();
    assert!(toy::run(&mut resumed, 600) == toy::run(&mut fresh(), 600));
}

#[test]
fn bad_settings_are_readable_errors() {
    let build = |config: Config| {
        let critic = Box::new(toy::LinearCritics::new(3, 2, 0.02, 0));
        Learner::with_networks(
            toy::method(config),
            &Toy::new().spec,
            critic,
            Box::new(toy::LinearActor::new(0.005)),
            0,
        )
        .map(drop)
    };
    let cases: Vec<(Config, &str)> = vec![
        (
            Config { discount: 1.5, ..toy::config() },
            "discount: wanted a number from 0 to 1, got 1.5",
        ),
        (Config { tau: f64::NAN, ..toy::config() }, "tau: wanted a number from 0 to 1, got NaN"),
        (Config { batch: 0, ..toy::config() }, "batch: wanted at least 1, got 0"),
        (Config { actor_delay: 0, ..toy::config() }, "actor_delay: wanted at least 1, got 0"),
        (Config { capacity: 0, ..toy::config() }, "capacity: wanted at least 1, got 0"),
        (
            Config { pessimism: -1.0, ..toy::config() },
            "pessimism: wanted a finite number, at least 0, got -1",
        ),
        (
            Config {
                smoothing: Some(Smoothing { std: 0.2, clip: f64::INFINITY }),
                ..toy::config()
            },
            "smoothing.clip: wanted a finite number, at least 0, got inf",
        ),
    ];
    for (config, message) in cases {
        assert_eq!(build(config).unwrap_err().to_string(), message);
    }
    let wide = Box::new(toy::LinearCritics::new(3, 4, 0.02, 0));
    let actor = || Box::new(toy::LinearActor::new(0.005));
    let error =
        Learner::with_networks(toy::method(toy::config()), &Toy::new().spec, wide, actor(), 0);
    assert_eq!(error.unwrap_err().to_string(), "the critic's objectives: wanted 2 values, got 4");
    let check = |change: &dyn Fn(&mut EnvSpec)| {
        let mut spec = Toy::new().spec;
        change(&mut spec);
        spec.check().unwrap_err().to_string()
    };
    assert_eq!(
        check(&|spec| spec.objectives[1].limit = Some(3.0)),
        "toy: weight of the cost 'rest': wanted at most 0, as costs are positive and unwanted, \
         got 1"
    );
    assert_eq!(
        check(&|spec| spec.objectives[0].limit = Some(f32::NAN)),
        "toy: limit of 'track': wanted a finite number, got NaN"
    );
    assert_eq!(
        check(&|spec| spec.objectives[1].name = "track".into()),
        "toy: objectives: wanted names that differ, got 'track' twice"
    );
    assert_eq!(
        check(&|spec| spec.objectives.clear()),
        "toy: objectives: wanted at least one, got none"
    );
    assert_eq!(
        check(&|spec| spec.objectives[1].weight = f32::NAN),
        "toy: weight of 'rest': wanted a finite number, got NaN"
    );
    for name in ["cost", "rewrd"] {
        let mut spec = Toy::constrained().spec;
        spec.entropy = Some(name.into());
        let error = spec.check().unwrap_err().to_string();
        assert_eq!(
            error,
            format!("toy: objective of the entropy bonus: wanted one of the rewards, got {name}")
        );
    }
    let mut zero = Toy::new().spec;
    zero.objectives.iter_mut().for_each(|objective| objective.weight = 0.0);
    let critic = Box::new(toy::LinearCritics::new(3, 2, 0.02, 0));
    let error =
        Learner::with_networks(toy::method(toy::config()), &zero, critic, actor(), 0).unwrap_err();
    assert!(
        error.to_string().contains("weights: wanted one at least that is not 0, got only zeros"),
        "{error}"
    );
}

/// Every warm-up action of 200: uniform ones fill [-1, 1], the untrained policy's stay within its
/// noise.
#[test]
fn the_warm_up_takes_uniform_actions_or_the_policys() {
    let largest = |warm_up| {
        let mut learner = toy::learner(toy::method(Config { warm_up, ..toy::config() }), 3, 1);
        let mut action = [0.0];
        let mut largest = 0.0f32;
        for i in 0..200 {
            learner.act(&[0.0], Mode::Explore, &mut action).unwrap();
            largest = largest.max(action[0].abs());
            let obs = [i as f32];
            let next_obs = [i as f32 + 1.0];
            let outcome = Outcome::Running;
            learner
                .observe(Transition {
                    obs: &obs,
                    action: &action,
                    reward: &[0.0; 2],
                    next_obs: &next_obs,
                    outcome,
                })
                .unwrap();
        }
        largest
    };
    assert!(largest(WarmUp::Uniform) > 0.95);
    let policy = largest(WarmUp::Policy);
    assert!((0.45..0.75).contains(&policy), "0.3, and 200 draws of a deviation of 0.1: {policy}");
}

/// At the first update the networks are the same whatever the pessimism: its margin is in
/// proportion to it.
#[test]
fn pessimism_is_reported_where_it_acts() {
    let pessimism = |config: Config| {
        let mut seen = std::collections::BTreeMap::new();
        let mut trainer = toy::trainer(toy::learner(toy::method(config), 3, 1));
        let mut log = |_: u64, name: &str, value: f64| {
            seen.insert(name.to_owned(), value);
        };
        (0..250).for_each(|_| drop(trainer.step(&mut log).unwrap()));
        ["pessimism/target", "pessimism/actor"].map(|name| seen[name])
    };
    let [target, actor] = pessimism(toy::config());
    assert!(target > 0.0 && actor > 0.0);
    let [half, _] = pessimism(Config {
        pessimism: 0.5,
        actor_pessimism: 0.0,
        start_steps: 250,
        actor_delay: 1,
        ..toy::config()
    });
    let [whole, none] = pessimism(Config {
        actor_pessimism: 0.0,
        start_steps: 250,
        actor_delay: 1,
        ..toy::config()
    });
    assert_abs_diff_eq!(half, 0.5 * whole, epsilon = 1e-6 * whole);
    assert_abs_diff_eq!(none, 0.0, epsilon = 1e-6 * whole);
}

#[test]
fn nan_is_a_named_error_before_it_counts() {
    let fails = |mut env: Toy, length: u64| {
        let mut learner = toy::learner(toy::method(toy::config()), 3, 0);
        let evaluated = evaluate(&mut learner, &mut env, 1).unwrap_err().to_string();
        let mut trainer = Trainer::new(env, learner).unwrap();
        let error = (0..20).find_map(|_| trainer.step(&mut Silent).err());
        let error = error.expect("a NaN must not pass").to_string();
        assert_eq!(error, evaluated);
        let [episode] = trainer.cut_short() else { panic!("one world") };
        assert!(trainer.env_failed() && episode.returns.iter().all(|x| x.is_finite()));
        assert_eq!((episode.length, trainer.steps()), (length, length));
        error
    };
    let reward = fails(Toy { nan_reward_at: Some(7), ..Toy::new() }, 6);
    assert!(reward.contains("environment 'toy' after 6 steps of an episode: reward, 'rest': wanted a finite number, got NaN"), "{reward}");
    let obs = fails(Toy { nan_obs_at: Some(5), ..Toy::new() }, 4);
    assert!(
        obs.contains(
            "environment 'toy' after 4 steps of an episode: observation, component 0: wanted"
        ),
        "{obs}"
    );
}

#[test]
fn an_observation_that_is_not_finite_is_not_blamed_on_the_actor() {
    let mut learner = toy::learner(toy::method(toy::config()), 3, 0);
    let error = learner.act(&[f32::NAN], Mode::Exploit, &mut [0.0]).unwrap_err().to_string();
    assert!(
        error.contains("observation, component 0 is not finite") && error.contains("environment"),
        "{error}"
    );
}

#[test]
fn a_cost_at_rest_is_known_for_a_cost() {
    let mut spec = Toy::constrained().spec;
    spec.objectives[0].weight = 0.0;
    let critic = Box::new(toy::LinearCritics::new(3, 2, 0.02, 0));
    let actor = Box::new(toy::LinearActor::new(0.005));
    let learner =
        Learner::with_networks(toy::method(toy::config()), &spec, critic, actor, 0).unwrap();
    assert!(learner.weights()[0].is_sign_negative() && learner.weights()[0] == 0.0);
}

#[test]
fn an_episode_that_outlives_its_horizon_is_an_error_and_no_endless_loop() {
    let mut endless = Toy::new();
    endless.spec.horizon = 12;
    let wanted = "environment 'toy': still running after 12 steps; wanted Outcome::Truncated at \
         its horizon, 12";
    let critic = Box::new(toy::LinearCritics::new(3, 2, 0.02, 0));
    let actor = Box::new(toy::LinearActor::new(0.005));
    let mut learner =
        Learner::with_networks(toy::method(toy::config()), &endless.spec, critic, actor, 0)
            .unwrap();
    assert_eq!(evaluate(&mut learner, &mut endless, 1).unwrap_err().to_string(), wanted);
    let mut trainer = Trainer::new(endless, learner).unwrap();
    let error = (0..20).find_map(|_| trainer.step(&mut Silent).err()).unwrap();
    assert_eq!((error.to_string(), trainer.steps()), (wanted.to_owned(), 11));
}

#[test]
fn logs_explain_the_run() {
    let mut seen = std::collections::BTreeMap::new();
    let mut trainer = toy::trainer(toy::learner(toy::method(toy::config()), 3, 1));
    let mut log = |step: u64, name: &str, value: f64| {
        seen.insert(name.to_owned(), (step, value));
    };
    (0..300).for_each(|_| drop(trainer.step(&mut log).unwrap()));
    for name in [
        "critic_loss/track",
        "q/rest",
        "q_std/rest",
        "target/track",
        "bound/track",
        "pessimism/target",
        "pessimism/actor",
        "famo/rest",
        "clip_rate",
        "actor/objective",
    ] {
        let (step, value) = seen[name];
        assert!(value.is_finite() && step >= 299, "{name} at {step}: {value}");
    }
    let weights: f64 = ["famo/track", "famo/rest"].iter().map(|name| seen[*name].1).sum();
    assert_abs_diff_eq!(weights, 1.0, epsilon = 1e-12);
}

/// The mean of a column of `rows x objectives`, and the critics' covariance of two, averaged over
/// the rows; by plain loops.
fn mean_and_covariance(q: QView<'_>, [i, j]: [usize; 2]) -> [f64; 2] {
    let (critics, rows) = (q.critics() as f64, q.rows() as f64);
    let [mut total, mut covariance] = [0.0; 2];
    for row in 0..q.rows() {
        let of = |i: usize| (0..q.critics()).map(move |k| f64::from(q.get(k, row)[i]));
        let [first, second] = [i, j].map(|i| of(i).sum::<f64>() / critics);
        total += first / rows;
        covariance +=
            of(i).zip(of(j)).map(|(x, y)| (x - first) * (y - second)).sum::<f64>() / critics / rows;
    }
    [total, covariance]
}

/// Scalars of the wrong objective, or of a bound that is none, would explain another run.
#[test]
fn the_first_update_logs_what_its_batch_says() {
    let config = Config { start_steps: 100, pessimism: 0.5, ..toy::config() };
    let mut learner = toy::learner(toy::method(config.clone()), 3, 8);
    let mut replay = Replay::new(&Toy::new().spec, config.capacity).unwrap();
    let mut rng = Rng::new(8, Stream::Custom);
    for _ in 0..100 {
        let mut numbers = [0.0; 5];
        numbers.fill_with(|| rng.uniform_in(-1.0, 1.0) as f32);
        let [obs, action, next_obs] = [&numbers[..1], &numbers[1..2], &numbers[2..3]];
        let (reward, outcome) = (&numbers[3..], Outcome::Truncated);
        let transition = Transition { obs, action, reward, next_obs, outcome };
        learner.observe(transition).unwrap();
        replay.push(transition).unwrap();
    }
    let mut seen = std::collections::BTreeMap::new();
    let mut log = |_: u64, name: &str, value: f64| {
        seen.insert(name.to_owned(), value);
    };
    learner.update(&mut log).unwrap();

    // The same critics before their step, on the same batch.
    let mut batch = Batch::default();
    replay.sample(64, &mut Rng::new(8, Stream::Batch), &mut batch).unwrap();
    let mut values = vec![0.0; 3 * 64 * 2];
    let mut critics = toy::LinearCritics::new(3, 2, 0.02, 8);
    critics.values(Net::Online, &batch.obs, &batch.action, &mut values).unwrap();
    let q = QView::new(&values, 3, 2).unwrap();
    let mut bound = vec![0.0; 64 * 2];
    let query = BoundQuery { q, weights: &[1.0, 1.0], step: -0.5 };
    projection::Cholesky.project(query, &mut Scratch::default(), &mut bound).unwrap();
    let covariance = |pair| mean_and_covariance(q, pair)[1];
    for (i, name) in ["track", "rest"].into_iter().enumerate() {
        let [mean, variance] = mean_and_covariance(q, [i, i]);
        let lower = bound.iter().skip(i).step_by(2).map(|&b| f64::from(b)).sum::<f64>() / 64.0;
        assert_abs_diff_eq!(seen[&format!("q/{name}")], mean, epsilon = 1e-12);
        assert_abs_diff_eq!(seen[&format!("q_std/{name}")], variance.sqrt(), epsilon = 1e-12);
        assert_abs_diff_eq!(seen[&format!("bound/{name}")], lower, epsilon = 1e-6);
        assert!(lower < mean - 0.01, "{name}");
    }
    let wanted = covariance([0, 1]) / (covariance([0, 0]) * covariance([1, 1])).sqrt();
    assert_abs_diff_eq!(seen["correlation/track/rest"], wanted, epsilon = 1e-12);
}

#[test]
fn a_cost_that_counts_downwards_is_a_warning() {
    let words = |cost: f32| {
        let spec = Toy::constrained().spec;
        let critic = Box::new(toy::LinearCritics::new(3, 2, 0.02, 0));
        let actor = Box::new(toy::LinearActor::new(0.005));
        let method = toy::method(Config { start_steps: 2_000, ..toy::config() });
        let mut learner = Learner::with_networks(method, &spec, critic, actor, 0).unwrap();
        let mut words = toy::Words::default();
        for step in 0..1_500 {
            // Now and then it is on the other side of zero.
            let cost = if step % 3 == 0 { -cost } else { cost };
            let (obs, action, reward) = (&[0.5], &[0.1], &[cost, 0.0]);
            let outcome = Outcome::Running;
            learner.observe(Transition { obs, action, reward, next_obs: obs, outcome }).unwrap();
            learner.update(&mut words).unwrap();
        }
        words.0
    };
    assert!(words(0.1).is_empty());
    let warned = words(-0.1);
    assert!(
        warned.len() == 1 && warned[0].starts_with("the cost 'cost' added up to -33.2 in 1000")
    );
}

#[test]
fn an_action_in_an_environment_s_units_is_an_error() {
    let mut learner = toy::learner(toy::method(toy::config()), 3, 0);
    let (obs, action, reward, outcome) = (&[0.5], &[1.5], &[0.0; 2], Outcome::Running);
    let transition = Transition { obs, action, reward, next_obs: obs, outcome };
    let error = learner.observe(transition).unwrap_err().to_string();
    assert_eq!(
        error,
        "a transition's action, before EnvSpec::scale_action: wanted numbers in [-1, 1], got 1.5"
    );
}

#[test]
fn rewards_that_no_network_can_learn_are_an_error_and_large_ones_a_warning() {
    let learn = |size: f32| {
        let mut learner = toy::learner(toy::method(toy::config()), 3, 0);
        let mut words = toy::Words::default();
        for _ in 0..100 {
            let (obs, action, reward) = (&[0.5], &[0.1], &[size, -size]);
            let outcome = Outcome::Running;
            learner.observe(Transition { obs, action, reward, next_obs: obs, outcome })?;
            learner.update(&mut words)?;
        }
        Ok::<_, Error>(words.0)
    };
    assert!(learn(1.0).unwrap().is_empty());
    let words = learn(1e5).unwrap();
    assert!(words.len() == 1 && words[0].contains("rewards reach 1.0e5"), "{words:?}");
    let error = learn(1e25).unwrap_err().to_string();
    assert_eq!(
        error,
        "size of the rewards: wanted at most 1e15, so that squares of values fit \
        float32, got 1e25"
    );
}

#[test]
fn what_does_not_fit_into_memory_is_an_error_before_it_is_asked_for() {
    let spec = Toy::new().spec;
    for (change, wanted) in [
        ((|config| config.batch = 9_000_000_000_000_000_000) as fn(&mut Config), "batch: wanted"),
        (|config| config.networks.hidden = vec![1_000_000_000_000], "networks.hidden: wanted"),
    ] {
        let mut config = toy::config();
        change(&mut config);
        let error = Learner::new(toy::method(config), &spec, &toy::Linear, 0).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error}");
    }
}

/// A world whose simulation fails once.
struct Unstable {
    inner: Toy,
    steps: u64,
    fails_at: u64,
}

impl Env for Unstable {
    fn spec(&self) -> &EnvSpec {
        &self.inner.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.inner.reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.steps += 1;
        if self.steps == self.fails_at {
            let what = "the simulation is unstable".to_owned();
            return Err(Error::Env { env: "toy".to_owned(), what });
        }
        self.inner.step(action, obs, reward)
    }
}

#[test]
fn a_world_that_fails_ends_its_episode_and_not_the_training() {
    let env = Unstable { inner: Toy::new(), steps: 0, fails_at: 35 };
    let learner = || toy::learner(toy::method(toy::config()), 3, 0);
    let mut trainer = Trainer::new(env, learner()).unwrap();
    trainer.run(34, &mut Silent).unwrap();
    let error = trainer.step(&mut Silent).unwrap_err().to_string();
    assert!(trainer.env_failed() && error.contains("the simulation is unstable"), "{error}");
    assert_eq!((trainer.steps(), trainer.agent().replay().len()), (34, 34));
    let mut state = State::default();
    trainer.save(&mut state).unwrap();
    trainer.run(40, &mut Silent).unwrap();
    assert!(!trainer.env_failed());
    assert_eq!((trainer.steps(), trainer.agent().replay().len()), (74, 74));

    let env = Toy { nan_obs_at: Some(3), ..Toy::new() };
    let mut trainer = Trainer::new(env, learner()).unwrap();
    trainer.run(2, &mut Silent).unwrap();
    let error = trainer.step(&mut Silent).unwrap_err().to_string();
    assert!(
        trainer.env_failed() && error.contains("observation, component 0: wanted a finite number"),
        "{error}"
    );
    assert_eq!(trainer.steps(), 2);
}
