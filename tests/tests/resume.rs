//! A robot with real networks: 2,000 steps equal 1,000 + resume + 1,000, bit for bit.

use copq::{Agent, Config, Learner, Result, Rng, Silent, State, Stream, Trainer, projection};
use copq_experiments::{Plan, Run, RunFolder, RunSettings};

/// Small networks and a short warm-up, so that a test can train for real.
fn config() -> Config {
    let mut config = Config { start_steps: 300, batch: 32, ..Config::cop_td3() };
    config.networks.hidden = vec![32, 32];
    config
}

fn trainer(seed: u64, threads: usize) -> Result<Trainer> {
    let env = copq_envs_rapier::make("a/hopper")?;
    let (spec, config, mut rng) = (env.spec().clone(), config(), Rng::new(seed, Stream::Init));
    let critic = copq_candle::critic(&spec, 4, &config.networks, &mut rng)?.threads(threads)?;
    let actor = copq_candle::actor(&spec, &config.networks, &mut rng)?.threads(threads)?;
    Trainer::new(env, Box::new(Learner::new(config, &spec, Box::new(critic), Box::new(actor), seed)?), seed)
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
    // The second half begins in a trainer of another seed: nothing but the saved state may matter.
    let mut resumed = trainer(9, 1).unwrap();
    resumed.load(&half).unwrap();
    assert!(state_after(&mut resumed, 2_000) == whole);
}

#[test]
fn a_resumed_run_leaves_the_same_files() {
    let temporary = tempfile::tempdir().unwrap();
    let run = |name: &str, steps: u64| {
        let settings = RunSettings { steps, eval_every: 500, eval_episodes: 2, log_every: 250, ..Default::default() };
        let plan = Plan { run: settings, ..Plan::new("resume") };
        let path = temporary.path().join(name);
        let open = if path.exists() { RunFolder::resume } else { RunFolder::create };
        let folder = open(&path, &plan, &config()).unwrap();
        let env = copq_envs_rapier::make("a/hopper").unwrap();
        Run::new(trainer(0, 1).unwrap(), env, folder, settings).unwrap().silent().train().unwrap();
        path
    };
    let whole = run("whole", 2_000);
    run("halves", 1_000);
    let halves = run("halves", 2_000);
    for file in ["metrics.csv", "evaluations.csv", "checkpoint.safetensors"] {
        let read = |folder: &std::path::Path| std::fs::read(folder.join(file)).unwrap();
        assert!(read(&whole) == read(&halves), "{file} differs");
    }
}

#[test]
fn every_projection_trains_the_hopper() {
    for &name in projection::names() {
        let projection = projection::by_name(name).unwrap();
        let env = copq_envs_rapier::make("a/hopper").unwrap();
        let (spec, mut rng) = (env.spec().clone(), Rng::new(0, Stream::Init));
        let critics = projection.critics(3);
        let critic = copq_candle::critic(&spec, critics, &config().networks, &mut rng).unwrap();
        let actor = copq_candle::actor(&spec, &config().networks, &mut rng).unwrap();
        let learner = Learner::new(config(), &spec, Box::new(critic), Box::new(actor), 0).unwrap();
        let learner: Box<dyn Agent> = Box::new(learner.projection(projection));
        let mut trainer = Trainer::new(env, learner, 0).unwrap();
        (0..500).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
    }
}
