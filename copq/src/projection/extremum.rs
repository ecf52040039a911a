//! The point of the confidence ellipsoid where the scalarised value is extreme.

use super::vector::{add_scaled, dot, rms};
use super::{Deviations, Ellipsoid, Work};

/// `mean + step * Sigma u / sqrt(u' Sigma u)` (paper Table B.1, "extremum").
///
/// Its scalarised margin is the standard deviation of the scalarised value, the largest margin of
/// the methods that use correlations. Where the scalarised value has no disagreement
/// (`Sigma u = 0`), the offset jumps unless Sigma is also zero; offset and gradient count as zero.
///
/// ```
/// use copq::projection::{BoundQuery, Extremum, Projection, QView, Scratch};
///
/// // Three critics; their totals are 15, 8 and 13: 12 with a standard deviation of 2.943920.
/// let q = QView::new(&[10.0, 5.0, 12.0, -4.0, 11.0, 2.0], 3, 2)?;
/// let mut low = [0.0; 2];
/// let bound = BoundQuery { q, weights: &[1.0, 1.0], step: -1.0 };
/// Extremum.project(bound, &mut Scratch::default(), &mut low)?;
/// assert!((low[0] + low[1] - (12.0 - 2.943920)).abs() < 1e-5);
/// // The second objective bears it all: the first, whose mean is 11, rises.
/// assert!((low[0] - 11.792594).abs() < 1e-5 && (low[1] + 2.736514).abs() < 1e-5);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Extremum;

impl Ellipsoid for Extremum {
    fn name(&self) -> &'static str {
        "extremum"
    }

    fn reads_covariances(&self) -> bool {
        true
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], work: &mut Work, out: &mut [f64]) {
        let [e] = work.split([x.critics()]);
        standardise(x, u, e);
        x.covariance(e, out);
    }

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        work: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        let critics = x.critics() as f64;
        let [e, grad_y] = work.split([x.critics(), x.critics()]);
        let std = standardise(x, u, e);
        if std == 0.0 {
            return;
        }
        // The gradient of e = y / std is X grad / K; that of y = X u is its part orthogonal to e,
        // over std.
        x.scalarised(grad, grad_y);
        let along = dot(grad_y, e) / critics;
        add_scaled(grad_y, -along, e);
        for (i, grad_x) in grad_x.chunks_exact_mut(x.critics()).enumerate() {
            add_scaled(grad_x, grad[i] / critics, e);
            add_scaled(grad_x, u[i] / (critics * std), grad_y);
        }
    }
}

/// Writes e = X u / sqrt(u' Sigma u) and returns the root; both are zero if the root is only
/// rounding error.
fn standardise(x: &Deviations<'_>, u: &[f64], e: &mut [f64]) -> f64 {
    x.scalarised(u, e);
    let std = rms(e);
    if x.is_rounding(u, std) {
        e.fill(0.0);
        return 0.0;
    }
    e.iter_mut().for_each(|e| *e /= std);
    std
}
