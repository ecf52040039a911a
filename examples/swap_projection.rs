//! Trains briefly with every projection on the same robot and seed: each learns, in one table. To
//! see which is better takes several seeds and about 150,000 steps (`examples/compare.rs`, `copq
//! sweep`).
//!
//! `cargo run --release -p copq-examples --example swap_projection`

use copq::{Learner, Method, Result, Silent, Trainer, projection};
use copq_candle::Candle;

fn main() -> Result<()> {
    let steps = copq_examples::steps(20_000)?;
    for name in projection::names() {
        let env = copq_envs_rapier::make("a/hopper")?;

        // The swap is this one word; the critics that the projection needs come with it.
        let method = Method::cop_td3()
            .bound(projection::by_name(name)?)
            .warm_up(steps.min(1_000).div_ceil(2));

        let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
        let mut trainer = Trainer::new(env, learner)?;
        trainer.run(steps, &mut Silent)?;
        let evaluation = trainer.evaluate(10)?;
        println!(
            "{name:16} {:6.1} steps, returns {:.1?}",
            evaluation.mean_length(),
            evaluation.mean()
        );
    }
    Ok(())
}
