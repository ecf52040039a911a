//! What a step of the environment costs on rapier and on MuJoCo 3.17.0, in CPU time of its thread.
//!
//! Both run the tasks `a/ROBOT` with random actions, in alternating rounds. The arguments name the
//! robots, by default all.

use anyhow::Result;
use copq_bench::{ROBOTS, episodes, spread, text};
use copq_envs::Options;
use copq_envs_mujoco::mujoco_rs;

const ROUNDS: usize = 41;
const STEPS: usize = 400;

fn main() -> Result<()> {
    println!(
        "us a step, median (smallest-largest) of {ROUNDS} alternating rounds of {STEPS} steps; \
         ratio by round"
    );
    let named: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |robot: &&str| named.is_empty() || named.iter().any(|name| name == robot);
    ROBOTS.into_iter().filter(wanted).try_for_each(compare)
}

fn compare(robot: &str) -> Result<()> {
    let name = format!("a/{robot}");
    let mut rapier = copq_envs_rapier::make(&name)?;
    let mut mujoco = mujoco_rs::make_with(&name, &Options::default())?;
    let mut times = [const { Vec::new() }; 2];
    for round in 0..ROUNDS {
        for (times, env) in times.iter_mut().zip([&mut rapier, &mut mujoco]) {
            times.push(episodes(&mut **env, STEPS, round as u64)? / 1e3);
        }
    }
    let mut ratios: Vec<_> =
        times[0].iter().zip(&times[1]).map(|(rapier, mujoco)| mujoco / rapier).collect();
    let [rapier, mujoco] = times.each_mut().map(|times| text(spread(times)));
    println!(
        "{robot:<12} rapier {rapier}  MuJoCo {mujoco}  MuJoCo/rapier {}",
        text(spread(&mut ratios))
    );
    Ok(())
}
