//! A projection of your own, and a learner that trains with it.

use copq::projection::{Deviations, Ellipsoid, Work};
use copq::{Learner, Method, Result, Silent, Trainer};
use copq_candle::Candle;

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

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        _: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        let scale = grad[0] * u[0] / (x.std(0).max(1e-12) * x.critics() as f64);
        x.objective(0).iter().zip(grad_x).for_each(|(x, grad_x)| *grad_x += scale * x);
    }
}

fn main() -> Result<()> {
    let env = copq_envs_rapier::make("a/hopper")?;
    let mut method = Method::cop_td3().bound(SafetyOnly).warm_up(100);
    method.config.batch = 16;
    let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    trainer.run(200, &mut Silent)?;
    println!("{}", trainer.evaluate(2)?);
    Ok(())
}
