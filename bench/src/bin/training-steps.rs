//! Whole environment steps of training on MuJoCo's hopper, for `bench/run.py`: acting, stepping,
//! storing, updating.
//!
//! A line `time NAME STEPS` is answered with a step's milliseconds, as wall time and as CPU time.
//! `shares NAME STEPS` is answered with the shares of time that updates, the environment and acting
//! took over that many further steps. `td3` is plain TD3, as in Stable-Baselines3 (2 critics and
//! nothing more). `cop` is COP-Q on TD3 with everything: FAMO and optimistic exploration. `ppo` and
//! `cppo-pid` take all 40 passes in each epoch, so that all programs do the same work. Their steps
//! are best counted in epochs of 2,048.

use std::collections::BTreeMap;
use std::io::{BufRead, Write, stdin, stdout};
use std::time::Instant;

use anyhow::{Result, bail};
use copq::{Agent, Ensemble, Env, Learner, Method, Silent, Trainer, on_policy};
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

fn time(trainer: &mut Trainer<Box<dyn Agent>>, steps: u64) -> Result<String> {
    let start = Instant::now();
    let cpu = process_time();
    run(trainer, steps)?;
    let scale = 1e-6 / steps as f64;
    Ok(format!("{} {}", start.elapsed().as_nanos() as f64 * scale, (process_time() - cpu) * scale))
}

fn shares(trainer: &mut Trainer<Box<dyn Agent>>, steps: u64) -> Result<String> {
    let start = Instant::now();
    let before = trainer.timing();
    run(trainer, steps)?;
    let whole = start.elapsed();
    let after = trainer.timing();
    let parts = [after.update - before.update, after.env - before.env, after.act - before.act];
    Ok(parts.map(|part| part.div_duration_f64(whole).to_string()).join(" "))
}

fn run(trainer: &mut Trainer<Box<dyn Agent>>, steps: u64) -> copq::Result<()> {
    trainer.run(steps, &mut Silent)
}

/// A trainer whose warm-up or first epoch is over.
fn trainer(name: &str) -> Result<Trainer<Box<dyn Agent>>> {
    let options = Options { senses: Senses::Gymnasium, ..Options::default() };
    let task = if name == "cppo-pid" { "b/hopper" } else { "gym/hopper" };
    let env = make_with(task, &options)?;
    let spec = env.spec();
    let candle = Candle::default();
    let off_policy = |method: Method| Learner::new(method.warm_up(START), spec, &candle, 0);
    let (agent, start): (Box<dyn Agent>, u64) = match name {
        "td3" => (Box::new(off_policy(Method::td3())?), START),
        "cop" => (Box::new(off_policy(Method::cop_td3_oac().critics(Ensemble::Joint(4)))?), START),
        _ => {
            let mut method = on_policy::Method::by_name(name)?;
            method.config.anneal_steps = None;
            method.config.target_kl = f64::MAX;
            let epoch = method.config.steps_per_epoch as u64;
            (Box::new(on_policy::Learner::new(method, spec, &candle, 0)?), epoch)
        }
    };
    let mut trainer = Trainer::new(env, agent)?;
    run(&mut trainer, start)?;
    Ok(trainer)
}
