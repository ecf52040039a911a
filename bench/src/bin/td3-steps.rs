//! Whole environment steps of training on MuJoCo's hopper, for `bench/run.py`: acting, stepping, storing, updating.
//!
//! A line `time NAME STEPS` is answered with a step's milliseconds, on the wall and on the processors; `shares NAME
//! STEPS` with the parts of that many further steps' time that went into updates, into the environment and into acting.
//! `td3` is plain TD3 as Stable-Baselines3 has it (2 critics, no more than it does); `cop` is COP-Q on TD3 with all that
//! there is: FAMO and optimistic exploration.

use std::collections::BTreeMap;
use std::io::{BufRead, Write, stdin, stdout};
use std::time::Instant;

use anyhow::{Result, bail};
use copq::projection::{Cholesky, ScalarisedMin};
use copq::{Config, Learner, Projection, Rng, Silent, Stream, Trainer};
use copq_bench::process_time;
use copq_envs::Options;
use copq_envs::robot::Senses;
use copq_envs_mujoco::mujoco_rs::make_with;

/// Steps with random actions before the updates begin.
const START: u64 = 1_000;

fn main() -> Result<()> {
    let mut trainers = BTreeMap::new();
    for line in stdin().lock().lines() {
        let line = line?;
        let words: Vec<_> = line.split_whitespace().collect();
        let [question, name, steps] = words[..] else { bail!("wanted QUESTION NAME STEPS, got {line}") };
        if !trainers.contains_key(name) {
            trainers.insert(name.to_owned(), trainer(name)?);
        }
        let Some(trainer) = trainers.get_mut(name) else { bail!("{name} is not running") };
        match question {
            "time" => println!("{}", time(trainer, steps.parse()?)?),
            "shares" => println!("{}", shares(trainer, steps.parse()?)?),
            _ => bail!("{question}: wanted time or shares"),
        }
        stdout().flush()?;
    }
    Ok(())
}

fn time(trainer: &mut Trainer, steps: u64) -> Result<String> {
    let (start, cpu) = (Instant::now(), process_time());
    run(trainer, steps)?;
    let scale = 1e-6 / steps as f64;
    Ok(format!("{} {}", start.elapsed().as_nanos() as f64 * scale, (process_time() - cpu) * scale))
}

fn shares(trainer: &mut Trainer, steps: u64) -> Result<String> {
    let (start, before) = (Instant::now(), trainer.timing());
    run(trainer, steps)?;
    let (whole, after) = (start.elapsed(), trainer.timing());
    let parts = [after.update - before.update, after.env - before.env, after.act - before.act];
    Ok(parts.map(|part| part.div_duration_f64(whole).to_string()).join(" "))
}

fn run(trainer: &mut Trainer, steps: u64) -> copq::Result<()> {
    (0..steps).try_for_each(|_| trainer.step(&mut Silent).map(drop))
}

/// A trainer whose warm-up is over.
fn trainer(name: &str) -> Result<Trainer> {
    let options = Options { senses: Senses::Gymnasium, ..Options::default() };
    let env = make_with("gym/hopper", &options)?;
    let (config, critics, projection): (_, _, Box<dyn Projection>) = match name {
        "td3" => (Config::td3(), 2, Box::new(ScalarisedMin)),
        "cop" => (Config::cop_td3_oac(), 4, Box::new(Cholesky)),
        _ => bail!("{name}: wanted td3 or cop"),
    };
    let config = Config { start_steps: START, ..config };
    let (spec, networks) = (env.spec().clone(), config.networks.clone());
    let mut rng = Rng::new(0, Stream::Init);
    let critic = copq_candle::critic(&spec, critics, &networks, &mut rng)?;
    let actor = copq_candle::actor(&spec, &networks, &mut rng)?;
    let learner = Learner::new(config, &spec, Box::new(critic), Box::new(actor), 0)?.projection(projection);
    let mut trainer = Trainer::new(env, Box::new(learner), 0)?;
    run(&mut trainer, START)?;
    Ok(trainer)
}
