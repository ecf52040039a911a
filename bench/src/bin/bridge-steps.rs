//! Steps of a Python environment through the bridge, for `bench/peers/bridge_steps.py`.
//!
//! A line `TASK PYTHON STEPS` is answered with the wall time of a step in microseconds, over that
//! many random actions. Resets are not timed.

use std::collections::BTreeMap;
use std::io::{BufRead, Write, stdin, stdout};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use copq::{Env, Outcome, Rng};
use copq_envs_python::{Options, PythonEnv};

fn main() -> Result<()> {
    let mut envs = BTreeMap::new();
    for line in stdin().lock().lines() {
        let line = line?;
        let words: Vec<_> = line.split_whitespace().collect();
        let [task, python, steps] = words[..] else {
            bail!("wanted TASK PYTHON STEPS, got {line}")
        };
        if !envs.contains_key(task) {
            let options = Options { python: Some(python.into()), ..Options::default() };
            envs.insert(task.to_owned(), PythonEnv::new(task, &options)?);
        }
        let Some(env) = envs.get_mut(task) else { bail!("{task} is not running") };
        println!("{}", microseconds(env, steps.parse()?)?);
        stdout().flush()?;
    }
    Ok(())
}

fn microseconds(env: &mut PythonEnv, steps: u32) -> Result<f64> {
    let spec = env.spec().clone();
    let mut rng = Rng::with_stream(1, 1);
    let mut obs = vec![0.0; spec.obs_len];
    let mut reward = vec![0.0; spec.objectives.len()];
    let mut action = vec![0.0; spec.action_len()];
    let mut unit = action.clone();
    let mut outcome = Outcome::Truncated;
    let mut spent = Duration::ZERO;
    for step in 0..steps {
        if outcome != Outcome::Running {
            env.reset(step.into(), &mut obs)?;
        }
        unit.iter_mut().for_each(|number| *number = rng.uniform_in(-1.0, 1.0) as f32);
        spec.scale_action(&unit, &mut action);
        let began = Instant::now();
        outcome = env.step(&action, &mut obs, &mut reward)?;
        spent += began.elapsed();
    }
    Ok(1e6 * spent.as_secs_f64() / f64::from(steps))
}
