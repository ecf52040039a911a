//! A run's folder as a whole, one of its files damaged.

use std::path::Path;

use bolero::check;
use copq::{Agent, Env, EnvSpec, Learner, Method, Outcome, Result, State, Trainer};
use copq_candle::Candle;
use copq_experiments::{Plan, Run, RunFolder, RunSettings};

use crate::{Damage, damaged};

/// A world in which nothing happens.
#[derive(Clone)]
pub struct Still(pub EnvSpec);

impl Env for Still {
    fn spec(&self) -> &EnvSpec {
        &self.0
    }

    fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
        obs.fill(0.5);
        Ok(())
    }

    fn step(&mut self, _: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        obs.fill(0.5);
        reward.fill(1.0);
        Ok(Outcome::Running)
    }

    fn save(&self, _: &mut State) -> Result<()> {
        Ok(())
    }

    fn load(&mut self, _: &State) -> Result<()> {
        Ok(())
    }
}

fn method() -> Method {
    let mut method = Method::cop_td3().warm_up(10);
    method.config.networks.hidden = vec![4];
    method.config.batch = 4;
    method
}

fn run(folder: RunFolder, plan: &Plan) -> Result<Run> {
    let spec = EnvSpec::new("still", 1, 1).reward("safety", 1.0).reward("speed", 1.0);
    let world = Still(spec.horizon(1_000));
    let learner = Learner::new(method(), &world.0, &Candle::default(), 0)?;
    let trainer = Trainer::new(world.clone(), Box::new(learner) as Box<dyn Agent>)?;
    Ok(Run::new(trainer, Some(Box::new(world)), folder, plan.run)?.silent())
}

#[test]
fn run_folder() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let settings = RunSettings {
        steps: 40,
        eval_every: 20,
        eval_episodes: 1,
        log_every: 10,
        checkpoint_every: 20,
        ..RunSettings::default()
    };
    let plan = Plan { task: "still".to_owned(), run: settings, ..Plan::new(&method()) };
    // Evaluation waits for the end of an episode, which a still world does not have.
    let plan = Plan { run: RunSettings { eval_every: 0, ..plan.run }, ..plan };
    let folder = RunFolder::create(&whole, &plan, &method().config).unwrap();
    run(folder, &plan).unwrap().train().unwrap();
    let names = ["config.toml", "metrics.csv", "evaluations.csv", "checkpoint.safetensors"];
    let sound = names.map(|name| std::fs::read(whole.join(name)).unwrap());
    let more = Plan { run: RunSettings { steps: 60, ..plan.run }, ..plan };
    check!().with_type::<(u8, Damage)>().for_each(|(which, damage)| {
        let which = usize::from(*which) % names.len();
        for (name, bytes) in names.iter().zip(&sound) {
            std::fs::write(whole.join(name), bytes).unwrap();
        }
        std::fs::write(whole.join(names[which]), damaged(&sound[which], damage)).unwrap();
        resume(&whole, &more);
    });
}

/// Goes on, or says why not.
fn resume(path: &Path, plan: &Plan) {
    let Ok(folder) = RunFolder::resume(path, plan, &method().config) else { return };
    if let Ok(mut run) = run(folder, plan) {
        drop(run.trainer_mut().run(3, &mut copq::Silent));
    }
}
