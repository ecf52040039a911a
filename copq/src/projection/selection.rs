//! What the double-Q baselines share: the choice of a critic, and the way from the mean to it.

use super::QView;

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
/// A NaN or an infinity in any critic comes through the mean, also when its share is zero.
pub(super) fn blend(q: QView<'_>, row: usize, objective: usize, chosen: usize, step: f32) -> f32 {
    let value = |k| f64::from(q.get(k, row)[objective]);
    let mean = (0..q.critics()).map(value).sum::<f64>() / q.critics() as f64;
    let share = f64::from(step.abs());
    ((1.0 - share) * mean + share * value(chosen)) as f32
}

/// Writes the gradient of [`blend`] with respect to every critic.
pub(super) fn blend_vjp(
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
