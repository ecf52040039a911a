//! A network of your own: critics with layer normalisation, as a candle-nn module.
//!
//! `cargo run --release -p copq-examples --example custom_network`

use candle_nn::{Module, VarBuilder, layer_norm_no_bias, linear};
use copq::{Learner, Method, Result, Silent, Trainer};
use copq_candle::{Candle, Modules};

/// Observation and action in, one value for each objective out.
fn critic(
    vars: VarBuilder<'_>,
    input: usize,
    output: usize,
) -> candle_core::Result<Box<dyn Module + Send>> {
    let first = linear(input, 64, vars.pp("first"))?;
    let norm = layer_norm_no_bias(64, 1e-5, vars.pp("norm"))?;
    let last = linear(64, output, vars.pp("last"))?;
    Ok(Box::new(move |x: &_| last.forward(&norm.forward(&first.forward(x)?)?.relu()?)))
}

fn main() -> Result<()> {
    let steps = copq_examples::steps(5_000)?;
    for normed in [true, false] {
        let env = copq_envs_rapier::make("a/hopper")?;
        let mut method = Method::cop_td3().warm_up((steps / 4).max(1));
        method.config.networks.hidden = vec![64];

        // Both use copq's own policy.
        let learner = match normed {
            true => Learner::new(method, env.spec(), &Modules::with_critics(critic), 0)?,
            false => Learner::new(method, env.spec(), &Candle::default(), 0)?,
        };
        let mut trainer = Trainer::new(env, learner)?;
        trainer.run(steps, &mut Silent)?;
        let name = if normed { "with layer normalisation" } else { "without" };
        println!("{name}: {}", trainer.evaluate(10)?);
    }
    Ok(())
}
