//! Every projection on the same robot and seed, in one loop: what a bound is worth.
//!
//! `cargo run --release --example swap_projection -- 20000` trains each for that many steps.

use copq::{Config, Learner, Projection, Result, Rng, Silent, Stream, Trainer, evaluate, projection};

const TASK: &str = "a/hopper";
const SEED: u64 = 0;
const EPISODES: usize = 10;

fn main() -> Result<()> {
    let steps = std::env::args().nth(1).map_or(20_000, |steps| steps.parse().expect("a number of steps"));
    for name in projection::names() {
        let returns = train(projection::by_name(name)?, steps)?;
        println!("{name:16} {returns:.1?}");
    }
    Ok(())
}

/// The mean return of every objective after training.
fn train(projection: Box<dyn Projection>, steps: u64) -> Result<Vec<f64>> {
    let env = copq_envs_rapier::make(TASK)?;
    let config = Config { start_steps: (steps / 4).min(1_000), ..Config::td3() };
    let discount = config.discount;

    // The one thing besides the projection itself that a projection decides: how many critics it wants.
    let (spec, mut rng) = (env.spec().clone(), Rng::new(SEED, Stream::Init));
    let critics = projection.critics(spec.objectives.len());
    let critic = copq_candle::critic(&spec, critics, &config.networks, &mut rng)?;
    let actor = copq_candle::actor(&spec, &config.networks, &mut rng)?;
    let learner = Learner::new(config, &spec, Box::new(critic), Box::new(actor), SEED)?.projection(projection);

    let mut trainer = Trainer::new(env, Box::new(learner), SEED)?;
    while trainer.steps() < steps {
        trainer.step(&mut Silent)?;
    }
    let mut world = copq_envs_rapier::make(TASK)?;
    Ok(evaluate(trainer.agent_mut(), world.as_mut(), EPISODES, SEED, discount)?.mean())
}
