//! What the double-Q baselines share: the choice of a critic, and the step from the mean towards
//! it.

use super::{BoundQuery, QView, Scratch};
use crate::Result;

/// The bound that takes one critic for each row and objective. `choose` gets the row and its
/// weights, and returns which critic an objective's value comes from.
pub(super) fn project<'a, C: Fn(usize) -> usize>(
    bound: BoundQuery<'a>,
    scratch: &mut Scratch,
    out: &mut [f32],
    choose: impl Fn(usize, &'a [f32]) -> C,
) -> Result<()> {
    let BoundQuery { q, step, .. } = bound;
    let directions = bound.check(out)?;
    for (row, out) in out.chunks_exact_mut(q.objectives()).enumerate() {
        let chosen = choose(row, directions.weights(row));
        for (i, out) in out.iter_mut().enumerate() {
            *out = blend(q, row, i, chosen(i), step);
        }
    }
    scratch.report_clips(0, q.rows());
    Ok(())
}

/// The gradient of that bound.
pub(super) fn vjp<'a, C: Fn(usize) -> usize>(
    bound: BoundQuery<'a>,
    grad_out: &[f32],
    grad_q: &mut [f32],
    choose: impl Fn(usize, &'a [f32]) -> C,
) -> Result<()> {
    let BoundQuery { q, step, .. } = bound;
    let directions = bound.check_vjp(grad_out, grad_q)?;
    for (row, grad) in grad_out.chunks_exact(q.objectives()).enumerate() {
        let chosen = choose(row, directions.weights(row));
        for (i, &grad) in grad.iter().enumerate() {
            blend_vjp(q, row, i, chosen(i), step, grad, grad_q);
        }
    }
    Ok(())
}

/// The position of the smallest value, the first of equals. A NaN is never the smallest.
pub(super) fn worst(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::INFINITY);
    for (k, value) in values.enumerate() {
        if value < best.1 {
            best = (k, value);
        }
    }
    best.0
}

/// (1 - |step|) mean + |step| Q_chosen of one objective in one row: exactly Q_chosen for |step| =
/// 1, the mean for 0.
///
/// A NaN or an infinity in any critic comes through the mean, even when its share is zero.
fn blend(q: QView<'_>, row: usize, objective: usize, chosen: usize, step: f32) -> f32 {
    let value = |k| f64::from(q.get(k, row)[objective]);
    let mean = (0..q.critics()).map(value).sum::<f64>() / q.critics() as f64;
    let share = f64::from(step.abs());
    ((1.0 - share) * mean + share * value(chosen)) as f32
}

/// Writes the gradient of [`blend`] with respect to every critic.
fn blend_vjp(
    q: QView<'_>,
    row: usize,
    objective: usize,
    chosen: usize,
    step: f32,
    grad: f32,
    grad_q: &mut [f32],
) {
    let grad = f64::from(grad);
    let share = f64::from(step.abs());
    for k in 0..q.critics() {
        let own = if k == chosen { share } else { 0.0 };
        grad_q[q.range(k, row)][objective] =
            (grad * ((1.0 - share) / q.critics() as f64 + own)) as f32;
    }
}
