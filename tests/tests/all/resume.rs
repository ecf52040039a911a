//! A robot with real networks: 2,000 steps equal 1,000 + resume + 1,000, bit for bit.

use copq::projection::{self, Extremum};
use copq::{
    ActorKind, AdjustedEnv, Agent, Env, EnvSpec, Learner, Method, Mode, Policy, Result, Silent,
    State, Trainer, on_policy,
};
use copq_candle::Candle;
use copq_experiments::{Plan, Run, RunFolder, RunSettings};

/// Small networks and a short warm-up, so that a test can train for real.
fn method() -> Method {
    small(Method::cop_td3())
}

fn small(method: Method) -> Method {
    let mut method = method.warm_up(300);
    method.config.batch = 32;
    method.config.networks.hidden = vec![32, 32];
    method
}

fn trainer(seed: u64, threads: usize) -> Result<Trainer> {
    let env = copq_envs_rapier::make("a/hopper")?;
    let learner = Learner::new(method(), env.spec(), &Candle::threads(threads), seed)?;
    Trainer::new(env, Box::new(learner))
}

fn state_after(trainer: &mut Trainer, steps: u64) -> State {
    while trainer.steps() < steps {
        trainer.step(&mut Silent).unwrap();
    }
    let mut state = State::default();
    trainer.save(&mut state).unwrap();
    state
}

#[test]
fn the_same_seed_gives_the_same_bits_with_one_thread_or_two() {
    let run = |seed, threads| state_after(&mut trainer(seed, threads).unwrap(), 700);
    let one = run(1, 1);
    assert!(run(1, 1) == one, "the same seed twice");
    assert!(run(1, 2) == one, "two threads");
    assert!(run(2, 1) != one, "another seed");
}

#[test]
fn a_resumed_trainer_goes_on_bit_for_bit() {
    let whole = state_after(&mut trainer(0, 1).unwrap(), 2_000);
    let half = state_after(&mut trainer(0, 1).unwrap(), 1_000);
    // The second half begins in a trainer that has been elsewhere: nothing but the saved state may
    // matter.
    let mut resumed = trainer(0, 1).unwrap();
    resumed.run(1_200, &mut Silent).unwrap();
    resumed.load(&half).unwrap();
    assert!(state_after(&mut resumed, 2_000) == whole);
}

#[test]
fn an_evaluation_leaves_the_training_episode_as_it_was() {
    let whole = state_after(&mut trainer(0, 1).unwrap(), 500);
    let mut evaluated = trainer(0, 1).unwrap();
    evaluated.run(317, &mut Silent).unwrap();
    assert_eq!(evaluated.evaluate(2).unwrap(), evaluated.evaluate(2).unwrap());
    assert!(state_after(&mut evaluated, 500) == whole);
}

#[test]
fn a_checkpoint_says_what_it_is_of_and_anything_else_is_refused() {
    let state = state_after(&mut trainer(0, 1).unwrap(), 10);
    let refused = |method: Method, task: &str, seed| {
        let env = copq_envs_rapier::make(task).unwrap();
        let learner = Learner::new(method, env.spec(), &Candle::default(), seed).unwrap();
        Trainer::new(env, learner).unwrap().load(&state).unwrap_err().to_string()
    };
    let other = |what: &str, own: &str, saved: &str| {
        format!("{what} of the saved learner: wanted {own}, got {saved}")
    };
    assert_eq!(refused(method(), "a/hopper", 1), other("seed", "1", "0"));
    assert_eq!(refused(method().named("mine"), "a/hopper", 0), other("method", "mine", "cop-td3"));
    assert_eq!(
        refused(method().bound(Extremum), "a/hopper", 0),
        other("bound", "Extremum", "Cholesky")
    );
    assert_eq!(refused(method(), "a/walker2d", 0), other("task", "a/walker2d", "a/hopper"));
    let hopper = copq_envs_rapier::make("a/hopper").unwrap();
    let env = AdjustedEnv::new(hopper).order("vsc").unwrap();
    let learner = Learner::new(method(), env.spec(), &Candle::default(), 0).unwrap();
    let error = Trainer::new(env, learner).unwrap().load(&state).unwrap_err().to_string();
    assert_eq!(error, other("objectives", "velocity,safety,control", "safety,velocity,control"));
    let plain = copq_envs_rapier::make("a/hopper").unwrap();
    let learner = Learner::new(method(), plain.spec(), &Candle::default(), 0).unwrap();
    let ordered = AdjustedEnv::new(plain).order("vsc").unwrap();
    let error = Trainer::new(ordered, learner).unwrap_err().to_string();
    assert!(
        error.starts_with("the environment of a learner made for another: its objectives: wanted"),
        "{error}"
    );
    let mut far = method();
    far.config.discount = 0.99;
    assert_eq!(refused(far, "a/hopper", 0), other("discount", "0.99", "0.995"));
    let agent = state.child("agent").unwrap();
    let spec = copq_envs_rapier::make("a/hopper").unwrap().spec().clone();
    let other_spec = copq_envs_rapier::make("a/walker2d").unwrap().spec().clone();
    let load = |spec: &EnvSpec| {
        let networks = &method().config.networks;
        Policy::load(agent, spec, networks, ActorKind::Deterministic, &Candle::default())
    };
    assert!(load(&spec).is_ok());
    let error = load(&other_spec).unwrap_err();
    assert_eq!(error.to_string(), other("task", "a/walker2d", "a/hopper"));
}

#[test]
fn a_policy_comes_back_without_its_run() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("policy.safetensors");
    for method in [method(), Method::sac().warm_up(20)] {
        let env = copq_envs_rapier::make("a/hopper").unwrap();
        let learner = Learner::new(method, env.spec(), &Candle::default(), 0).unwrap();
        let mut trainer = Trainer::new(env, learner).unwrap();
        trainer.run(60, &mut Silent).unwrap();
        trainer.agent().save_policy(&path).unwrap();
        let mut policy = Policy::read(&path, &Candle::default()).unwrap();
        let obs: Vec<f32> = (0..11).map(|i| 0.1 * i as f32).collect();
        let mut acted = [[0.0; 3]; 2];
        policy.act(&obs, &mut acted[0]).unwrap();
        trainer.agent_mut().act(&obs, Mode::Exploit, &mut acted[1]).unwrap();
        assert_eq!(acted[0], acted[1]);
        if policy.method() == Some("sac") {
            // Which has no normaliser: sums of its network overflow.
            let error = policy.act(&[f32::MAX; 11], &mut acted[0]).unwrap_err().to_string();
            assert_eq!(error, "the policy's action: wanted finite numbers, got NaN");
        }
    }
}

/// A run in two halves, and whole: the same files, whatever its method keeps between steps.
fn same_files(task: &str, plan: &Plan, make: impl Fn(&EnvSpec) -> Box<dyn Agent>) {
    let temporary = tempfile::tempdir().unwrap();
    let run = |name: &str, steps: u64| {
        let settings = RunSettings {
            steps,
            eval_every: 500,
            eval_episodes: 2,
            log_every: 250,
            ..Default::default()
        };
        let plan = Plan { run: settings, task: task.to_owned(), ..plan.clone() };
        let path = temporary.path().join(name);
        let open = if path.exists() { RunFolder::resume } else { RunFolder::create };
        // Settings are written down, and not looked at.
        let folder = open(&path, &plan, &method().config).unwrap();
        let [env, other] = [(); 2].map(|()| copq_envs_rapier::make(task).unwrap());
        let agent = make(env.spec());
        let trainer = Trainer::new(env, agent).unwrap();
        let run = Run::new(trainer, Some(other), folder, settings);
        run.unwrap().silent().train().unwrap();
        path
    };
    let whole = run("whole", 2_000);
    run("halves", 1_000);
    let halves = run("halves", 2_000);
    for file in ["metrics.csv", "evaluations.csv", "checkpoint.safetensors"] {
        let read = |folder: &std::path::Path| std::fs::read(folder.join(file)).unwrap();
        assert!(read(&whole) == read(&halves), "{}: {file} differs", plan.method);
    }
}

/// Multipliers, explorers and critics of every kind.
#[test]
fn a_resumed_run_leaves_the_same_files() {
    for (task, method) in [
        ("a/hopper", Method::cop_td3()),
        ("a/hopper", Method::cop_td3_oac()),
        ("a/hopper", Method::by_name("redq-oac").unwrap()),
        ("b/hopper", Method::cop_cal()),
        ("b/hopper", Method::saclag_ucb()),
        ("b/hopper", Method::sac_pid()),
    ] {
        let mut method = small(method);
        method.config.updates_per_step = method.config.updates_per_step.min(2);
        same_files(task, &Plan::new(&method), |spec| {
            Box::new(Learner::new(method.clone(), spec, &Candle::default(), 0).unwrap())
        });
    }
}

/// Broken off in the middle of an epoch.
#[test]
fn a_resumed_on_policy_run_leaves_the_same_files() {
    for name in ["cppo-pid", "rcpo", "cup"] {
        let mut method = on_policy::Method::by_name(name).unwrap();
        method.config.steps_per_epoch = 300;
        method.config.passes = 2;
        let plan = Plan::on_policy(name);
        same_files("b/hopper", &plan, |spec| {
            let learner = on_policy::Learner::new(method.clone(), spec, &Candle::default(), 0);
            Box::new(learner.unwrap())
        });
    }
}

#[test]
fn every_projection_trains_the_hopper() {
    for &name in projection::names() {
        let env = copq_envs_rapier::make("a/hopper").unwrap();
        let method = method().bound(projection::by_name(name).unwrap());
        let learner = Learner::new(method, env.spec(), &Candle::default(), 0).unwrap();
        Trainer::new(env, learner).unwrap().run(500, &mut Silent).unwrap();
    }
}
