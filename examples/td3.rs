//! COP-Q on TD3, part by part: a hopper begins to learn to be safe first, fast second, frugal third
//! (it stands after about 110,000 steps).
//!
//! `cargo run --release -p copq-examples --example td3`

use copq::projection::Cholesky;
use copq::{FamoConfig, Learner, Method, Result, Silent, Trainer};
use copq_candle::Candle;

fn main() -> Result<()> {
    let steps = copq_examples::steps(20_000)?;
    let env = copq_envs_rapier::make("a/hopper")?;

    // TD3 becomes COP-Q when its critics value every objective and its targets use their Cholesky
    // bound.
    let td3 = Method::td3().bound(Cholesky).warm_up(steps.min(1_000).div_ceil(2));
    let mut method = td3.balance(FamoConfig::default());
    method.config.target_period = 1;

    // `Method::cop_td3()` is the preset to start with, `Method::cop_td3_paper()` the paper's main
    // comparison.
    let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    for _ in 0..4 {
        trainer.run(steps / 4, &mut Silent)?;
        println!("after {} steps: {}", trainer.steps(), trainer.evaluate(10)?);
    }
    Ok(())
}
