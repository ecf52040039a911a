//! What a step costs on MuJoCo 3.17.0, in CPU time of its thread: with the bare C calls, our engine
//! and our environment.
//!
//! By itself it prints a table of medians over interleaved rounds. With `--serve` it measures on
//! demand for `bench/peers/gymnasium_steps.py`: a line `WHAT ROBOT STEPS` is answered with
//! nanoseconds per step.

use std::io::{BufRead, Write, stdin, stdout};

use anyhow::{Context, Result, bail};
use copq::Rng;
use copq_bench::{ROBOTS, cpu_time, episodes, spread, text};
use copq_envs::robot::Senses;
use copq_envs::{Options, Physics, RobotSpec, task_with};
use copq_envs_mujoco::mujoco_rs::{make_with, physics};
use mujoco_rs::wrappers::{MjData, MjModel};

const WHATS: [&str; 3] = ["bare", "engine", "env"];
const ROUNDS: usize = 61;
const STEPS: usize = 400;

fn main() -> Result<()> {
    if std::env::args().any(|arg| arg == "--serve") { serve() } else { table() }
}

fn serve() -> Result<()> {
    for line in stdin().lock().lines() {
        let line = line?;
        let words: Vec<_> = line.split_whitespace().collect();
        let [what, robot, steps] = words[..] else { bail!("wanted WHAT ROBOT STEPS, got {line}") };
        println!("{}", measure(what, robot, steps.parse().context("STEPS")?)?);
        stdout().flush()?;
    }
    Ok(())
}

fn table() -> Result<()> {
    println!(
        "us a step, median (smallest-largest) of {ROUNDS} interleaved rounds of {STEPS} steps; \
         ratio by round"
    );
    for robot in ROBOTS {
        let mut times = WHATS.map(|_| Vec::new());
        for _ in 0..ROUNDS {
            for (times, what) in times.iter_mut().zip(WHATS) {
                times.push(measure(what, robot, STEPS)? / 1e3);
            }
        }
        let mut ratios: Vec<_> =
            times[1].iter().zip(&times[0]).map(|(engine, bare)| engine / bare).collect();
        let [bare, engine, env] = times.each_mut().map(|times| text(spread(times)));
        let ratio = text(spread(&mut ratios));
        println!(
            "{robot:<12} bare {bare}  engine {engine}  engine/bare {ratio}  environment {env}"
        );
    }
    Ok(())
}

/// Nanoseconds per step.
fn measure(what: &str, robot: &str, steps: usize) -> Result<f64> {
    let options = Options { senses: Senses::Gymnasium, ..Options::default() };
    let name = format!("gym/{robot}");
    let spec = task_with(&name, &options)?.robot;
    match what {
        "bare" => bare(&spec, steps),
        "engine" => engine(&spec, steps),
        "env" => Ok(episodes(&mut *make_with(&name, &options)?, steps, 1)?),
        _ => bail!("{what} is none of {WHATS:?}"),
    }
}

/// Controls within the motors' ranges, a row per step.
fn controls(robot: &RobotSpec, steps: usize) -> Vec<Vec<f64>> {
    let mut rng = Rng::with_stream(1, 1);
    let row = |_| {
        robot.actuators.iter().map(|motor| rng.uniform_in(motor.range[0], motor.range[1])).collect()
    };
    (0..steps).map(row).collect()
}

fn bare(robot: &RobotSpec, steps: usize) -> Result<f64> {
    let model = MjModel::from_xml_string(&robot.mjcf(copq_envs_mujoco::mujoco_rs::version()?))?;
    let mut data = MjData::new(&model);
    data.qpos_mut().copy_from_slice(&robot.initial_qpos);
    data.forward();
    let controls = controls(robot, steps);
    let start = cpu_time();
    for ctrl in &controls {
        data.ctrl_mut().copy_from_slice(ctrl);
        (0..robot.frame_skip).for_each(|_| data.step());
    }
    Ok((cpu_time() - start) / steps as f64)
}

fn engine(robot: &RobotSpec, steps: usize) -> Result<f64> {
    let mut physics = physics(robot)?;
    let controls = controls(robot, steps);
    let start = cpu_time();
    for ctrl in &controls {
        physics.step(ctrl, robot.frame_skip)?;
    }
    Ok((cpu_time() - start) / steps as f64)
}
