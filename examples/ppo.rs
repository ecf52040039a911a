//! On-policy: PPO with a PID controller for its costs, part by part, in four environments at once.
//!
//! `cargo run --release -p copq-examples --example ppo`

use copq::on_policy::{Constraint, Learner, Method};
use copq::{Env, PidConfig, Result, Trainer};
use copq_candle::Candle;

fn main() -> Result<()> {
    let steps = copq_examples::steps(100_000)?;
    let envs: Vec<Box<dyn Env>> =
        (0..4).map(|_| copq_envs_rapier::make("b/hopper")).collect::<Result<_>>()?;

    // CPPOPID is PPO with a controller; its gains are per unit of an episode's cost.
    let pid = PidConfig { cap: 100.0, ..PidConfig::cppo_pid() }; // the paper uses no cap
    let mut method = Method::ppo();
    method.config.constraint = Some(Constraint::Pid(pid));
    method.config.anneal_steps = Some(steps);
    // A whole episode of 1,000 steps in each environment: a controller sees only finished ones.
    method.config.steps_per_epoch = steps.min(4_000) as usize / 4 * 4;

    let spec = envs[0].spec().clone();
    let learner = Learner::new(method, &spec, &Candle::default(), 0)?;
    let mut trainer = Trainer::with_envs(envs, learner)?.threads(2);
    trainer.run(steps, &mut |step: u64, name: &str, value: f64| {
        if name == "cost_window/cost" {
            println!("{step:>7} steps: an episode costs {value:.1}");
        }
    })?;
    let limit = spec.limit(0).unwrap_or_default();
    println!("{}the limit is {limit}", trainer.evaluate(10)?);
    Ok(())
}
