//! Clipped double-Q for every objective on its own.

use super::selection::{blend, blend_vjp, worst};
use super::{Bound, Projection, QView, Scratch};
use crate::{Ensemble, Result};

/// Every objective's least value over the critics for a negative step, or its greatest for a
/// positive one; the other way round where the objective's weight is negative or -0 (a cost).
///
/// The bound is `mean + |step| (Q_k - mean)`, objective by objective, so that steps -1 and 1 give
/// exactly the extreme values, and step 0 the mean. The first of equal critics gets the gradient. A
/// NaN in any critic makes its objective's bound NaN.
#[derive(Clone, Copy, Debug, Default)]
pub struct IndependentMin;

impl Projection for IndependentMin {
    fn name(&self) -> &'static str {
        "independent-min"
    }

    fn ensemble(&self) -> Ensemble {
        Ensemble::Separate { cost: 2, reward: 2 }
    }

    fn project(&self, bound: Bound<'_>, scratch: &mut Scratch, out: &mut [f32]) -> Result<()> {
        let Bound { q, step, .. } = bound;
        let directions = bound.check(out)?;
        for (row, out) in out.chunks_exact_mut(q.objectives()).enumerate() {
            let weights = directions.weights(row);
            for (i, out) in out.iter_mut().enumerate() {
                let chosen = choose(q, row, i, weights[i], step);
                *out = blend(q, row, i, chosen, step);
            }
        }
        scratch.report_clips(0, q.rows());
        Ok(())
    }

    fn vjp(
        &self,
        bound: Bound<'_>,
        _scratch: &mut Scratch,
        grad_out: &[f32],
        grad_q: &mut [f32],
    ) -> Result<()> {
        let Bound { q, step, .. } = bound;
        let directions = bound.check_vjp(grad_out, grad_q)?;
        for (row, grad) in grad_out.chunks_exact(q.objectives()).enumerate() {
            let weights = directions.weights(row);
            for (i, &grad) in grad.iter().enumerate() {
                let chosen = choose(q, row, i, weights[i], step);
                blend_vjp(q, row, i, chosen, step, grad, grad_q);
            }
        }
        Ok(())
    }
}

fn choose(q: QView<'_>, row: usize, objective: usize, weight: f32, step: f32) -> usize {
    // A weight of -0 is still a cost's: that of a multiplier at rest.
    let sign = if (step > 0.0) == weight.is_sign_negative() { 1.0 } else { -1.0 };
    worst((0..q.critics()).map(|k| sign * f64::from(q.get(k, row)[objective])))
}
