//! Clipped double-Q for each objective on its own.

use super::selection::{self, worst};
use super::{BoundQuery, Projection, QView, Scratch};
use crate::{Ensemble, Result};

/// Every objective's smallest value over the critics for a negative step, or its largest for a
/// positive one; the other way round where the objective's weight is negative or -0 (a cost).
///
/// The bound is `mean + |step| (Q_k - mean)`, objective by objective, so that steps -1 and 1 give
/// exactly the extreme values, and step 0 the mean. The first of equal critics gets the gradient. A
/// NaN in any critic makes its objective's bound NaN.
///
/// ```
/// use copq::projection::{BoundQuery, IndependentMin, Projection, QView, Scratch};
///
/// let q = QView::new(&[10.0, 5.0, 12.0, -4.0, 11.0, 2.0], 3, 2)?; // three critics
/// let mut low = [0.0; 2];
/// let rewards = BoundQuery { q, weights: &[1.0, 1.0], step: -1.0 };
/// IndependentMin.project(rewards, &mut Scratch::default(), &mut low)?;
/// assert_eq!(low, [10.0, -4.0]); // the first critic's and the second's
///
/// // If the first is a cost, pessimism takes its largest value.
/// let cost_first = BoundQuery { weights: &[-1.0, 1.0], ..rewards };
/// IndependentMin.project(cost_first, &mut Scratch::default(), &mut low)?;
/// assert_eq!(low, [12.0, -4.0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct IndependentMin;

impl Projection for IndependentMin {
    fn name(&self) -> &'static str {
        "independent-min"
    }

    fn ensemble(&self) -> Ensemble {
        Ensemble::Separate { cost: 2, reward: 2 }
    }

    fn project(&self, bound: BoundQuery<'_>, scratch: &mut Scratch, out: &mut [f32]) -> Result<()> {
        let BoundQuery { q, step, .. } = bound;
        selection::project(bound, scratch, out, |row, weights| {
            move |i| choose(q, row, i, weights[i], step)
        })
    }

    fn vjp(
        &self,
        bound: BoundQuery<'_>,
        _scratch: &mut Scratch,
        grad_out: &[f32],
        grad_q: &mut [f32],
    ) -> Result<()> {
        let BoundQuery { q, step, .. } = bound;
        selection::vjp(bound, grad_out, grad_q, |row, weights| {
            move |i| choose(q, row, i, weights[i], step)
        })
    }
}

fn choose(q: QView<'_>, row: usize, objective: usize, weight: f32, step: f32) -> usize {
    // A weight of -0 is still a cost's: its multiplier is zero.
    let sign = if (step > 0.0) == weight.is_sign_negative() { 1.0 } else { -1.0 };
    worst((0..q.critics()).map(|k| sign * f64::from(q.get(k, row)[objective])))
}
