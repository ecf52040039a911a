//! A policy by itself, without learner or replay. It is read from its file and acts in its task for
//! one episode, on rapier with the default preset. (A policy's file does not say which environment
//! it learned in; a run's folder does, and `copq rollout` plays it there.)
//!
//! `cargo run --release -p copq-examples --example act -- runs/FOLDER/policy-best.safetensors`

use std::time::Instant;

use copq::{Error, Policy, Result, Rollout};
use copq_candle::Candle;

fn main() -> Result<()> {
    let wanted = "a policy's file, such as runs/FOLDER/policy-best.safetensors";
    let file =
        std::env::args().nth(1).ok_or_else(|| Error::invalid("the argument", wanted, "none"))?;
    let mut policy = Policy::read(file, &Candle::default())?;
    let method = policy.method().unwrap_or("a method it does not say");
    println!("{} by {method}, which put {} first", policy.task(), policy.objectives().join(", "));

    let mut world = Rollout::new(copq_envs_rapier::make(policy.task())?)?;
    let mut action = vec![0.0; policy.action_len()];
    let mut times = Vec::new();
    world.reset(0)?;
    while world.is_running() {
        let began = Instant::now();
        // In [-1, 1]; `Policy::scale` converts it to the robot's own units, as `Rollout` does here.
        policy.act(world.obs(), &mut action)?;
        times.push(began.elapsed());
        world.step(&action)?;
    }
    times.sort();
    let episode = world.episode();
    println!("{} steps returned {:.1?}", episode.length, episode.returns);
    println!("an action takes {:.1?} (median)", times[times.len() / 2]);
    Ok(())
}
