//! A projection of your own, with its gradient: cautious about safety, neutral about the rest.
//!
//! `cargo run --release -p copq-examples --example custom_projection -- 20000` trains the hopper
//! with it for that many steps.

use copq::projection::{Deviations, Ellipsoid, Work, check_projection};
use copq::{Learner, Method, Result, Silent, Trainer};
use copq_candle::Candle;

/// The mean, less `caution * u_0` standard deviations of the first objective. Here u is the
/// direction of the weights; for a cost u_0 is negative, which turns the bound upwards.
#[derive(Debug)]
struct SafetyOnly {
    caution: f64,
}

impl Ellipsoid for SafetyOnly {
    fn name(&self) -> &'static str {
        "safety-only"
    }

    /// The offset from the mean for one row. X holds the critics' deviations, and u is the unit
    /// direction of the weights.
    fn offset(&self, x: &Deviations<'_>, u: &[f64], _: &mut Work, out: &mut [f64]) {
        out.fill(0.0);
        out[0] = self.caution * x.std(0) * u[0];
    }

    /// Its gradient: d std / dx_k = x_k / (K std).
    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        _: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        let scale = self.caution * grad[0] * u[0] / (x.critics() as f64 * x.std(0).max(1e-12));
        x.objective(0).iter().zip(grad_x).for_each(|(x, grad_x)| *grad_x += scale * x);
    }
}

fn main() -> Result<()> {
    let steps = copq_examples::steps(20_000)?;
    check_projection(&SafetyOnly { caution: 2.0 }, 3, 2)?; // first: is the gradient right?

    let env = copq_envs_rapier::make("a/hopper")?;
    let method = Method::cop_td3().bound(SafetyOnly { caution: 2.0 }).warm_up((steps / 4).max(1));
    let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    trainer.run(steps, &mut Silent)?;
    println!("{}", trainer.evaluate(10)?);
    Ok(())
}
