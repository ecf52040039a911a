//! A projection of one's own, with its gradient: cautious about safety, neutral about the rest.
//!
//! `cargo run --release --example custom_projection -- 20000` trains the hopper with it for that many steps.

use copq::projection::{Bound, Deviations, Ellipsoid, Projection, QView, Scratch, Work};
use copq::{Config, Learner, Result, Rng, Silent, Stream, Trainer, evaluate};

/// The mean, less `caution` standard deviations of the first objective.
#[derive(Debug)]
struct SafetyOnly {
    caution: f64,
}

impl Ellipsoid for SafetyOnly {
    fn name(&self) -> &'static str {
        "safety-only"
    }

    /// How far from the mean, for one row: X holds the critics' deviations, u the unit direction of the weights.
    fn offset(&self, x: &Deviations<'_>, u: &[f64], _: &mut Work, out: &mut [f64]) {
        out.fill(0.0);
        out[0] = self.caution * x.std(0) * u[0];
    }

    /// Its gradient: d std / dx_k = x_k / (K std).
    fn offset_vjp(&self, x: &Deviations<'_>, u: &[f64], _: &mut Work, grad: &[f64], grad_x: &mut [f64]) {
        let scale = self.caution * grad[0] * u[0] / (x.critics() as f64 * x.std(0).max(1e-12));
        x.objective(0).iter().zip(grad_x).for_each(|(x, grad_x)| *grad_x += scale * x);
    }
}

/// A gradient is believed when it equals central differences.
fn check_gradient(projection: &dyn Projection) -> Result<()> {
    const NUDGE: f32 = 1e-2;
    let q = [1.0, 5.0, 2.0, 3.0, 4.0, 4.0];
    let bound = |q: &[f32]| -> Result<f32> {
        let (mut out, q) = ([0.0; 2], QView::new(q, 3, 2)?);
        projection.project(Bound { q, weights: &[1.0, 1.0], step: -1.0 }, &mut Scratch::default(), &mut out)?;
        Ok(out[0] + 2.0 * out[1])
    };
    let (mut grad, view) = ([0.0; 6], QView::new(&q, 3, 2)?);
    let asked = Bound { q: view, weights: &[1.0, 1.0], step: -1.0 };
    projection.vjp(asked, &mut Scratch::default(), &[1.0, 2.0], &mut grad)?;
    for i in 0..q.len() {
        let (mut up, mut down) = (q, q);
        (up[i], down[i]) = (q[i] + NUDGE, q[i] - NUDGE);
        let wanted = (bound(&up)? - bound(&down)?) / (2.0 * NUDGE);
        assert!((grad[i] - wanted).abs() < 1e-3, "gradient {i}: {}, not {wanted}", grad[i]);
    }
    Ok(())
}

fn main() -> Result<()> {
    let steps = copq_examples::steps(20_000)?;
    check_gradient(&SafetyOnly { caution: 2.0 })?;

    let env = copq_envs_rapier::make("a/hopper")?;
    let (spec, config) = (env.spec().clone(), Config { start_steps: (steps / 4).max(1), ..Config::cop_td3() });
    let mut rng = Rng::new(0, Stream::Init);
    let critic = copq_candle::critic(&spec, 4, &config.networks, &mut rng)?;
    let actor = copq_candle::actor(&spec, &config.networks, &mut rng)?;
    let learner = Learner::new(config, &spec, Box::new(critic), Box::new(actor), 0)?;
    let learner = learner.projection(SafetyOnly { caution: 2.0 }); // the swap

    let mut trainer = Trainer::new(env, Box::new(learner), 0)?;
    while trainer.steps() < steps {
        trainer.step(&mut Silent)?;
    }
    let mut world = copq_envs_rapier::make("a/hopper")?;
    let evaluation = evaluate(trainer.agent_mut(), world.as_mut(), 10, 0, 0.99)?;
    println!("{:?}: {:.1?}", spec.objectives, evaluation.mean());
    Ok(())
}
