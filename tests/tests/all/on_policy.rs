//! On-policy learners on a real robot: exact resume, several worlds, and what does not fit.

use copq::on_policy::{Learner, Method, Saute};
use copq::{AdjustedEnv, Agent, Env, Mode, Policy, Result, Silent, State, Trainer};
use copq_candle::{Candle, Modules};

/// Small networks and short epochs, so that a test can train for real.
fn method(name: &str) -> Method {
    let mut method = Method::by_name(name).unwrap();
    method.config.steps_per_epoch = 96;
    method.config.passes = 3;
    method.config.networks.hidden = vec![16, 16];
    method
}

fn env(method: &Method) -> Box<dyn Env> {
    let world = copq_envs_rapier::make("b/hopper").unwrap();
    match &method.config.saute {
        Some(saute) => Box::new(Saute::new(world, saute).unwrap()),
        None => Box::new(world),
    }
}

fn trainer(name: &str, worlds: usize) -> Trainer<Learner> {
    let method = method(name);
    let envs: Vec<_> = (0..worlds).map(|_| env(&method)).collect();
    let learner = Learner::new(method, envs[0].spec(), &Candle::default(), 3).unwrap();
    Trainer::with_envs(envs, learner).unwrap()
}

fn saved(trainer: &Trainer<Learner>) -> State {
    let mut state = State::default();
    trainer.save(&mut state).unwrap();
    state
}

#[test]
fn every_method_goes_on_bit_for_bit_from_mid_epoch() {
    for name in Method::names() {
        let mut whole = trainer(name, 1);
        whole.run(150, &mut Silent).unwrap();
        let middle = saved(&whole);
        whole.run(250, &mut Silent).unwrap();
        assert_eq!(whole.agent().epochs(), 4, "{name}");
        let mut resumed = trainer(name, 1);
        resumed.load(&middle).unwrap();
        resumed.run(250, &mut Silent).unwrap();
        assert!(saved(&resumed) == saved(&whole), "{name}");
        let other = if name == "ppo" { "cup" } else { "ppo" };
        assert!(trainer(other, 1).load(&middle).is_err(), "{name}");
    }
}

#[test]
fn several_worlds_give_the_same_bits_on_any_threads() {
    let run = |threads| {
        let mut trainer = trainer("cppo-pid", 4).threads(threads);
        trainer.run(100, &mut Silent).unwrap();
        let middle = saved(&trainer);
        trainer.run(200, &mut Silent).unwrap();
        assert_eq!((trainer.steps(), trainer.agent().epochs()), (300, 3));
        (middle, saved(&trainer))
    };
    let (middle, end) = run(1);
    assert!(run(3) == (middle.clone(), end.clone()));
    let mut resumed = trainer("cppo-pid", 4);
    resumed.load(&middle).unwrap();
    resumed.run(200, &mut Silent).unwrap();
    assert!(saved(&resumed) == end);
}

#[test]
fn what_does_not_fit_is_a_readable_error() {
    let free = copq_envs_rapier::make("a/hopper").unwrap();
    let made = |name: &str, env: &dyn Env| {
        Learner::new(method(name), env.spec(), &Candle::default(), 0).unwrap_err().to_string()
    };
    assert_eq!(
        made("rcpo", &free),
        "rcpo on 'a/hopper': wanted a task with a cost under a limit, such as b/hopper, got none"
    );
    let world = copq_envs_rapier::make("b/hopper").unwrap();
    assert_eq!(
        made("ppo-saute", &world),
        "ppo-saute's environment: wanted an environment that shows its budgets (on_policy::Saute), \
         got 'b/hopper'"
    );
    let saute = method("ppo-saute").config.saute.unwrap();
    assert_eq!(
        Saute::new(free, &saute).unwrap_err().to_string(),
        "Saute on 'a/hopper': wanted a task with a cost under a limit, such as b/hopper, got none"
    );
    let envs: Vec<Box<dyn Env>> = (0..5).map(|_| env(&method("ppo"))).collect();
    let learner = Learner::new(method("ppo"), envs[0].spec(), &Candle::default(), 0).unwrap();
    assert_eq!(
        Trainer::with_envs(envs, learner).unwrap_err().to_string(),
        "environments: wanted a divisor of steps_per_epoch, 96, got 5"
    );
    let envs: Vec<Box<dyn Env>> = (0..2).map(|_| env(&method("ppo"))).collect();
    let spec = envs[0].spec();
    let off_policy = copq::Learner::new(copq::Method::sac(), spec, &Candle::default(), 0).unwrap();
    assert_eq!(
        Trainer::with_envs(envs, off_policy).unwrap_err().to_string(),
        "environments of an agent that learns from one at a time: wanted 1, got 2"
    );
}

/// Modules are networks of off-policy methods.
#[test]
fn a_backend_says_what_it_has_not() {
    let env = env(&method("ppo"));
    let modules = Modules::with_critics(|_, _, _| unreachable!());
    let error = Learner::new(method("ppo"), env.spec(), &modules, 0).unwrap_err().to_string();
    assert_eq!(error, "on-policy methods need Backend::policy, which this backend has not");
}

#[test]
fn a_policy_comes_back_without_its_run_and_begins_another() {
    let temporary = tempfile::tempdir().unwrap();
    for name in ["cup", "ppo-saute"] {
        let path = temporary.path().join(name);
        let mut trainer = trainer(name, 1);
        trainer.run(200, &mut Silent).unwrap();
        let agent = trainer.agent_mut();
        agent.save_policy(&path).unwrap();
        let mut policy = Policy::read(&path, &Candle::default()).unwrap();
        let env = env(&method(name));
        let mut other = Learner::new(method(name), env.spec(), &Candle::default(), 9).unwrap();
        other.start_from(&State::read_file(&path).unwrap()).unwrap();
        let obs = vec![0.3; env.spec().obs_len];
        let mut actions = [[0.0; 3]; 3];
        agent.act(&obs, Mode::Exploit, &mut actions[0]).unwrap();
        policy.act(&obs, &mut actions[1]).unwrap();
        other.act(&obs, Mode::Exploit, &mut actions[2]).unwrap();
        assert!(actions[0] == actions[1] && actions[0] == actions[2], "{name}: {actions:?}");
    }
}

/// Fails every so many steps.
struct Unstable(Box<dyn Env>, usize);

impl Env for Unstable {
    fn spec(&self) -> &copq::EnvSpec {
        self.0.spec()
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.0.reset(seed, obs)
    }

    fn step(
        &mut self,
        action: &[f32],
        obs: &mut [f32],
        reward: &mut [f32],
    ) -> Result<copq::Outcome> {
        self.1 += 1;
        if self.1.is_multiple_of(37) {
            return Err(copq::Error::Unsupported { what: "unstable".to_owned() });
        }
        self.0.step(action, obs, reward)
    }
}

#[test]
fn worlds_that_fail_cost_their_steps_and_no_more() {
    for worlds in [1, 3] {
        let method = method("ppo-lag");
        let envs: Vec<Box<dyn Env>> =
            (0..worlds).map(|i| Box::new(Unstable(env(&method), 11 * i)) as Box<dyn Env>).collect();
        let learner = Learner::new(method, envs[0].spec(), &Candle::default(), 3).unwrap();
        let mut trainer = Trainer::with_envs(envs, learner).unwrap();
        let mut failures = 0;
        while trainer.agent().epochs() < 4 {
            if trainer.step(&mut Silent).is_err() {
                assert!(trainer.env_failed());
                failures += 1;
            }
        }
        assert!(failures > 6, "{failures}");
        assert!(trainer.steps() >= 4 * 96);
    }
}

#[test]
fn settings_that_cannot_be_used_are_named_before_anything_is_made() {
    let env = env(&method("ppo"));
    let refused = |change: fn(&mut copq::on_policy::Config)| {
        let mut method = Method::cppo_pid();
        change(&mut method.config);
        let made = Learner::new(method, env.spec(), &Candle::default(), 0);
        made.unwrap_err().to_string()
    };
    for (error, named) in [
        (
            refused(|config| config.steps_per_epoch = usize::MAX),
            "steps_per_epoch: wanted what fits",
        ),
        (
            refused(|config| config.networks.hidden = vec![1 << 40; 2]),
            "networks.hidden: wanted what",
        ),
        (refused(|config| config.batch = 0), "batch: wanted at least 1"),
        (refused(|config| config.gae = f64::NAN), "gae: wanted a number from 0 to 1, got NaN"),
        (refused(|config| config.max_norm = f64::NAN), "max_norm: wanted a positive number"),
        (refused(|config| config.clip = -0.1), "clip: wanted a finite number, at least 0"),
    ] {
        assert!(error.starts_with(named), "{error}");
    }
}

/// A spent budget's reward is not the task's: its critic says nothing of that.
#[test]
fn a_value_is_of_what_the_critic_was_taught() {
    for (name, is_told) in [("ppo-lag", true), ("ppo-saute", false)] {
        let mut trainer = trainer(name, 1);
        let obs = vec![0.1; env(&method(name)).spec().obs_len];
        let mut q = [0.0; 2];
        trainer.agent_mut().value(&obs, &[0.0; 3], &mut q).unwrap();
        assert_eq!(q[1].is_finite(), is_told, "{name}: {q:?}");
    }
}

#[test]
fn a_state_that_no_run_has_left_is_refused() {
    let mut whole = trainer("rcpo", 1);
    whole.run(150, &mut Silent).unwrap();
    let refused = |change: &dyn Fn(&mut State)| {
        let mut state = saved(&whole);
        change(state.child_mut("agent"));
        trainer("rcpo", 1).load(&state).unwrap_err().to_string()
    };
    for (wanted, change) in [
        (
            "rows of an environment of the saved epoch: wanted at most 96, got 97",
            &(|agent: &mut State| agent.child_mut("epoch").put("filled", [97_u64]))
                as &dyn Fn(&mut State),
        ),
        ("end of a path of the saved epoch: wanted one after a row", &|agent| {
            let epoch = agent.child_mut("epoch");
            let ends = epoch.get::<u64>("end_rows").unwrap().len();
            epoch.put("end_rows", vec![95_u64; ends]);
        }),
        ("ends of paths of environment 0 of the saved epoch: wanted one", &|agent| {
            let epoch = agent.child_mut("epoch");
            epoch.put("filled", [96_u64]);
            epoch.put("end_rows", [0_u64; 0]);
            epoch.put("end_values", [0.0_f32; 0]);
        }),
    ] {
        let said = refused(change);
        assert!(said.contains(wanted), "{said}");
    }
    let mut alone = trainer("rcpo", 1);
    alone.agent_mut().attend(1);
    let obs = vec![0.0; 11];
    let said = alone.agent_mut().act(&obs, Mode::Explore, &mut [0.0; 3]).unwrap_err().to_string();
    assert_eq!(
        said,
        "environment attended to: wanted one of 1, counted from 0 (Agent::prepare), got 1"
    );
}

/// Makes every f32 no number.
fn spoil(state: &mut State) {
    let names: Vec<String> = state.values().map(|(name, _)| name.to_owned()).collect();
    for name in names {
        let Ok(values) = state.get::<f32>(&name) else { continue };
        let spoilt = vec![f32::NAN; values.len()];
        match state.shape(&name).map(<[_]>::to_vec) {
            Some(shape) => state.put_shaped(&name, &shape, spoilt),
            None => state.put(&name, spoilt),
        }
    }
    let children: Vec<String> = state.children().map(|(name, _)| name.to_owned()).collect();
    children.iter().for_each(|name| spoil(state.child_mut(name)));
}

/// A critic that has diverged is told at the next step, not at the end of the next epoch.
#[test]
fn a_critic_that_has_diverged_is_told_at_once() {
    let mut trainer = trainer("cup", 1);
    trainer.run(100, &mut Silent).unwrap();
    let mut state = saved(&trainer);
    spoil(state.child_mut("agent").child_mut("critic.1"));
    trainer.load(&state).unwrap();
    let said = trainer.run(102, &mut Silent).unwrap_err().to_string();
    assert!(said.contains("value, component 1"), "{said}");
}

#[test]
fn a_cost_that_nothing_holds_counts_by_its_weight() {
    let learned = |name: &str, weights: &str| {
        let method = method(name);
        let world = copq_envs_rapier::make("b/hopper").unwrap();
        let world = AdjustedEnv::new(world).weights(weights).unwrap();
        let learner = Learner::new(method, world.spec(), &Candle::default(), 3).unwrap();
        let mut trainer = Trainer::new(world, learner).unwrap();
        trainer.run(150, &mut Silent).unwrap();
        let obs = vec![0.1; trainer.spec().obs_len];
        let mut action = vec![0.0; trainer.spec().action_len()];
        let agent = trainer.agent_mut();
        agent.act(&obs, Mode::Exploit, &mut action).unwrap();
        let mut values = [0.0; 2];
        agent.value(&obs, &action, &mut values).unwrap();
        (action, values.map(f32::is_nan))
    };
    let [free, priced] = ["cost=0", "cost=-100"].map(|weights| learned("ppo", weights));
    assert_ne!(free.0, priced.0);
    assert_eq!((free.1, priced.1), ([true, false], [true; 2]), "whose value the critic knows");
    assert_eq!(learned("ppo-lag", "cost=0"), learned("ppo-lag", "cost=-100"));
}
