//! REDQ with COP-OAC: ten critics, twenty updates a step, and an upper bound that guides
//! exploration.
//!
//! `cargo run --release -p copq-examples --example redq`

use copq::{Learner, Method, Optimism, Result, Silent, Trainer};
use copq_candle::Candle;

fn main() -> Result<()> {
    let steps = copq_examples::steps(3_000)?;
    let env = copq_envs_rapier::make("a/hopper")?;

    // Targets take the smaller of two random critics and the actor climbs the mean of all ten. The
    // upper bound for exploration uses all ten.
    let redq = Method::cop_td3_paper().redq().warm_up(steps.min(1_000).div_ceil(2));
    let method = redq.explore(Optimism::by("cholesky"));

    let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    trainer.run(steps, &mut Silent)?;
    println!("{}", trainer.evaluate(10)?);
    Ok(())
}
