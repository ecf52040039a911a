//! Clipped double-Q on the scalarised value: the whole vector of the critic that scalarises worst.

use super::selection::{self, worst};
use super::{BoundQuery, Projection, QView, Scratch};
use crate::{Ensemble, Result};

/// The values of the critic with the smallest `u . Q_k` for a negative step, or the largest for a
/// positive one.
///
/// The bound is `mean + |step| (Q_k - mean)`, so that steps -1 and 1 give exactly that critic's
/// values, and step 0 the mean. The first of equal critics is taken; where two are equal, the bound
/// jumps from one's values to the other's. A NaN in any critic makes its objective's bound NaN,
/// whichever critic is taken.
///
/// ```
/// use copq::projection::{BoundQuery, Projection, QView, ScalarisedMin, Scratch};
///
/// // Three critics, whose totals are 15, 8 and 13: the bound is what the second says.
/// let q = QView::new(&[10.0, 5.0, 12.0, -4.0, 11.0, 2.0], 3, 2)?;
/// let mut low = [0.0; 2];
/// let bound = BoundQuery { q, weights: &[1.0, 1.0], step: -1.0 };
/// ScalarisedMin.project(bound, &mut Scratch::default(), &mut low)?;
/// assert_eq!(low, [12.0, -4.0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ScalarisedMin;

impl Projection for ScalarisedMin {
    fn name(&self) -> &'static str {
        "scalarised-min"
    }

    fn ensemble(&self) -> Ensemble {
        Ensemble::Joint(2)
    }

    fn project(&self, bound: BoundQuery<'_>, scratch: &mut Scratch, out: &mut [f32]) -> Result<()> {
        let BoundQuery { q, step, .. } = bound;
        selection::project(bound, scratch, out, |row, weights| {
            let chosen = choose(q, row, weights, step);
            move |_| chosen
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
            let chosen = choose(q, row, weights, step);
            move |_| chosen
        })
    }
}

fn choose(q: QView<'_>, row: usize, weights: &[f32], step: f32) -> usize {
    let sign = if step > 0.0 { -1.0 } else { 1.0 };
    // Products of two f32 are exact in f64, so critics that are equal tie exactly.
    let score = |k| {
        q.get(k, row).iter().zip(weights).map(|(&q, &w)| f64::from(q) * f64::from(w)).sum::<f64>()
    };
    worst((0..q.critics()).map(|k| sign * score(k)))
}
