//! A projection of one's own, and a learner that trains with it.

use copq::projection::{Deviations, Ellipsoid, Work};
use copq::{Config, Learner, Result, Rng, Silent, Stream, Trainer};

/// Cautious about the first objective alone: one standard deviation for safety, none for the rest.
#[derive(Debug)]
struct SafetyOnly;

impl Ellipsoid for SafetyOnly {
    fn name(&self) -> &'static str {
        "safety-only"
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], _: &mut Work, out: &mut [f64]) {
        out.fill(0.0);
        out[0] = x.std(0) * u[0];
    }

    fn offset_vjp(&self, x: &Deviations<'_>, u: &[f64], _: &mut Work, grad: &[f64], grad_x: &mut [f64]) {
        let scale = grad[0] * u[0] / (x.std(0).max(1e-12) * x.critics() as f64);
        x.objective(0).iter().zip(grad_x).for_each(|(x, grad_x)| *grad_x = scale * x);
    }
}

fn main() -> Result<()> {
    let (env, seed) = (copq_envs_rapier::make("a/hopper")?, 0);
    let config = Config { start_steps: 100, batch: 16, ..Config::cop_td3() };
    let mut rng = Rng::new(seed, Stream::Init);
    let critic = copq_candle::critic(env.spec(), 4, &config.networks, &mut rng)?;
    let actor = copq_candle::actor(env.spec(), &config.networks, &mut rng)?;
    let learner = Learner::new(config, env.spec(), Box::new(critic), Box::new(actor), seed)?.projection(SafetyOnly);
    let mut trainer = Trainer::new(env, Box::new(learner), seed)?;
    while trainer.steps() < 200 {
        trainer.step(&mut Silent)?;
    }
    println!("{trainer:?}");
    Ok(())
}
