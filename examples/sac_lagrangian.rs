//! SAC under a constraint: run as fast as a speed limit allows.
//!
//! `cargo run --release -p copq-examples --example sac_lagrangian`

use copq::projection::IndependentMin;
use copq::{Constraint, Ensemble, LagrangianConfig, Learner, Method, Result, Silent, Trainer};
use copq_candle::Candle;

fn main() -> Result<()> {
    let steps = copq_examples::steps(20_000)?;
    let env = copq_envs_rapier::make("b/hopper")?; // a cost (speed) whose sum has a limit, and a reward

    // SAC with one critic of the cost and two of the reward, and a multiplier that learns how much
    // the limit matters.
    let plain = LagrangianConfig { augmentation: 0.0, ..Default::default() };
    let sac =
        Method::sac().bound(IndependentMin).critics(Ensemble::Separate { cost: 1, reward: 2 });
    let method = sac.constrain(Constraint::Lagrangian(plain)).warm_up(steps.min(1_000).div_ceil(2));

    let limit = env.spec().limit(0).unwrap_or_default();
    let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    trainer.run(steps, &mut Silent)?;
    let multiplier = -trainer.agent().weights()[0];
    println!("{}the limit is {limit}, the multiplier {multiplier:.3}", trainer.evaluate(10)?);
    Ok(())
}
