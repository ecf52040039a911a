//! COP-Q's own bound: the Cholesky factor of the critics' covariance, in priority order, with the
//! clip.

use super::clip::{rotate, rotate_vjp};
use super::factor::Factor;
use super::vector::dot;
use super::{Deviations, Ellipsoid, Work};

/// `mean + step * L R u`, with L the Cholesky factor of Sigma, objectives in priority order (paper
/// eqs. 10-13).
///
/// As long as the clip does not fire, the first objective's margin is its own standard deviation
/// times its weight. The margins of the others cover what the objectives before them leave
/// unexplained. Where `u . L u` would be negative, R turns u just far enough to make it zero (paper
/// A.1-A.4), so that always `u . L R u = max(0, u . L u)`.
///
/// No covariance is formed. The deviations themselves are orthogonalised. Therefore, an objective
/// that the earlier ones explain entirely adds no disagreement of its own, and critics that agree
/// give exactly the mean.
///
/// # Where it has no derivative
///
/// * A zero pivot, such as an objective on which all critics agree: the standard deviation has a
///   kink there like |x| at zero, and the gradient used is the middle of its two sides, 0. For two
///   critics and one objective, this is the tie of clipped double-Q, which here gives half of the
///   gradient to each. The bounds of the objectives after it jump. Next to an arbitrarily small
///   pivot, they depend on the direction in which the critics disagree about the objective, and
///   that direction has no limit. At a zero pivot, the direction is left out.
/// * `u . L u = 0`, where the clip starts: the bound is continuous, but its slope is not.
/// * `Sigma u = 0` with Sigma not zero, a scalarised value without disagreement: for example,
///   objectives valued (1, -1) and (-1, 1) under weights (1, 1). The bound jumps there, because the
///   limit of R u depends on the direction of approach. The clip counts as not fired.
///
/// ```
/// use copq::projection::{BoundQuery, Cholesky, Projection, QView, Scratch};
///
/// // Three critics, two objectives that disagree in opposite ways: the clip fires.
/// let q = QView::new(&[10.0, 5.0, 12.0, -4.0, 11.0, 2.0], 3, 2)?;
/// let mut scratch = Scratch::default();
/// let mut low = [0.0; 2];
/// Cholesky.project(BoundQuery { q, weights: &[1.0, 1.0], step: -1.0 }, &mut scratch, &mut low)?;
/// assert!((low[0] - 10.803884).abs() < 1e-5 && (low[1] - 1.196116).abs() < 1e-5);
/// assert_eq!(scratch.clip_rate(), 1.0);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Cholesky;

impl Ellipsoid for Cholesky {
    fn name(&self) -> &'static str {
        "cholesky"
    }

    fn reads_covariances(&self) -> bool {
        true
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], work: &mut Work, out: &mut [f64]) {
        let k = x.critics();
        let n = x.objectives();
        let [e, pivots, sum, p, rotated] = work.split([n * k, n, k, n, n]);
        let factor = Factor::new(x.values(), e, pivots);
        let fired = clipped_direction(x, &factor, u, sum, p, rotated);
        factor.times(rotated, sum, out);
        if fired {
            work.report_clip();
        }
    }

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        work: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        let k = x.critics();
        let n = x.objectives();
        let [e, pivots, sum, p, rotated, grad_e, grad_rotated, grad_p] =
            work.split([n * k, n, k, n, n, n * k, n, n]);
        let factor = Factor::new(x.values(), e, pivots);
        let fired = clipped_direction(x, &factor, u, sum, p, rotated);
        factor.bilinear_vjp(grad, rotated, sum, grad_e, grad_x);
        if fired {
            factor.transposed_times(grad, sum, grad_rotated);
            rotate_vjp(u, p, rotated, grad_rotated, grad_p);
            factor.bilinear_vjp(u, grad_p, sum, grad_e, grad_x);
        }
        factor.directions_vjp(grad_e, grad_x);
    }
}

/// Writes p = L'u and R u; returns whether the clip fired.
fn clipped_direction(
    x: &Deviations<'_>,
    factor: &Factor<'_>,
    u: &[f64],
    sum: &mut [f64],
    p: &mut [f64],
    rotated: &mut [f64],
) -> bool {
    factor.transposed_times(u, sum, p);
    if x.is_rounding(u, dot(p, p).sqrt()) {
        p.fill(0.0);
    }
    rotate(u, p, rotated)
}
