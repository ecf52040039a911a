//! Whole environment steps of training on MuJoCo's hopper, for `bench/run.py`: acting, stepping,
//! storing, updating.
//!
//! A line `time NAME STEPS` is answered with a step's milliseconds, on the wall and on the
//! processors; `shares NAME STEPS` with the parts of that many further steps' time that went into
//! updates, into the environment and into acting. `td3` is plain TD3 as Stable-Baselines3 has it (2
//! critics, no more than it does); `cop` is COP-Q on TD3 with all that there is: FAMO and
//! optimistic exploration.

use std::collections::BTreeMap;
use std::io::{BufRead, Write, stdin, stdout};
use std::time::Instant;

use anyhow::{Result, bail};
use copq::projection::ScalarisedMin;
use copq::{Ensemble, Learner, Method, Silent, Trainer};
use copq_bench::process_time;
use copq_candle::Candle;
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
        let [question, name, steps] = words[..] else {
            bail!("wanted QUESTION NAME STEPS, got {line}")
        };
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

fn time(trainer: &mut Trainer<Learner>, steps: u64) -> Result<String> {
    let start = Instant::now();
    let cpu = process_time();
    run(trainer, steps)?;
    let scale = 1e-6 / steps as f64;
    Ok(format!("{} {}", start.elapsed().as_nanos() as f64 * scale, (process_time() - cpu) * scale))
}

fn shares(trainer: &mut Trainer<Learner>, steps: u64) -> Result<String> {
    let start = Instant::now();
    let before = trainer.timing();
    run(trainer, steps)?;
    let whole = start.elapsed();
    let after = trainer.timing();
    let parts = [after.update - before.update, after.env - before.env, after.act - before.act];
    Ok(parts.map(|part| part.div_duration_f64(whole).to_string()).join(" "))
}

fn run(trainer: &mut Trainer<Learner>, steps: u64) -> copq::Result<()> {
    trainer.run(steps, &mut Silent)
}

/// A trainer whose warm-up is over.
fn trainer(name: &str) -> Result<Trainer<Learner>> {
    let options = Options { senses: Senses::Gymnasium, ..Options::default() };
    let env = make_with("gym/hopper", &options)?;
    let method = match name {
        "td3" => Method::td3().bound(ScalarisedMin),
        "cop" => Method::cop_td3_oac().critics(Ensemble::Joint(4)),
        _ => bail!("{name}: wanted td3 or cop"),
    };
    let learner = Learner::new(method.warm_up(START), env.spec(), &Candle::default(), 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    run(&mut trainer, START)?;
    Ok(trainer)
}
