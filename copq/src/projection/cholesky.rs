//! COP-Q's own bound: the Cholesky factor of the critics' covariance, in priority order, with the
//! clip.

use super::batch::Batch;
use super::clip::{turn, turn_vjp};
use super::deviations::rounding;
use super::factor::Factor;
use super::lanes::Lanes;
use super::number::Number;
use super::scratch::Buffers;
use super::vector::dot;
use super::{Deviations, Ellipsoid, Scratch, Work};

/// `mean + step * L R u`, with L the Cholesky factor of Sigma, objectives in priority order (paper
/// eqs. 10-13).
///
/// As long as the clip does not fire, the first objective's margin is its own standard deviation
/// times its weight; the others answer for what the ones before them leave unexplained. Where
/// `u . L u` would be negative, R turns u just far enough to make it zero (paper A.1-A.4), so that
/// always `u . L R u = max(0, u . L u)`.
///
/// No covariance is formed. The deviations themselves are orthogonalised, so that an objective that
/// the earlier ones explain entirely adds no disagreement of its own, and critics that agree give
/// exactly the mean.
///
/// # Where it has no derivative
///
/// * A zero pivot, such as an objective on which all critics agree: the standard deviation has a
///   kink there like |x| at zero, and the gradient used is the middle of its two sides, 0. For two
///   critics and one objective this is the tie of clipped double-Q, which here hands half of the
///   gradient to each.
/// * `u . L u = 0`, where the clip starts: the bound is continuous, its slope is not.
/// * `Sigma u = 0` with Sigma not zero, a scalarised value without disagreement: for objectives
///   valued (1, -1) and (-1, 1) under weights (1, 1). The bound jumps there, as the limit of R u
///   depends on where one comes from; the clip counts as not fired.
///
/// ```
/// use copq::projection::{Bound, Cholesky, Projection, QView, Scratch};
///
/// // Three critics, two objectives that disagree in opposite ways: the clip fires.
/// let q = QView::new(&[10.0, 5.0, 12.0, -4.0, 11.0, 2.0], 3, 2)?;
/// let mut scratch = Scratch::default();
/// let mut low = [0.0; 2];
/// Cholesky.project(Bound { q, weights: &[1.0, 1.0], step: -1.0 }, &mut scratch, &mut low)?;
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

    fn offset(&self, x: &Deviations<'_>, u: &[f64], work: &mut Work, out: &mut [f64]) {
        if offset(x.values(), u, &mut work.buffers, out) > 0.0 {
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
        offset_vjp(x.values(), u, &mut work.buffers, grad, grad_x);
    }

    fn project_blocks(&self, batch: Batch<'_>, scratch: &mut Scratch, out: &mut [f32]) -> usize {
        let rows = batch.whole::<Lanes>();
        let (line, buffers) = scratch.lanes();
        let clips = batch.project(0..rows, line, out, |x, u, out| offset(x, u, buffers, out));
        scratch.add_clips(clips);
        rows
    }

    fn vjp_blocks(
        &self,
        batch: Batch<'_>,
        scratch: &mut Scratch,
        grad_out: &[f32],
        grad_q: &mut [f32],
    ) -> usize {
        let rows = batch.whole::<Lanes>();
        let (line, buffers) = scratch.lanes();
        batch.vjp(0..rows, line, (grad_out, grad_q), |x, u, grad, grad_x| {
            offset_vjp(x, u, buffers, grad, grad_x)
        });
        rows
    }
}

/// Writes L R u; returns 1 where the clip fired, else 0.
#[inline(always)]
fn offset<T: Number>(x: &[T], u: &[T], buffers: &mut Buffers<T>, out: &mut [T]) -> T {
    let k = x.len() / u.len();
    let n = u.len();
    let [e, pivots, sum, p, turned] = buffers.split([n * k, n, k, n, n]);
    let factor = Factor::new(x, e, pivots);
    let fired = clipped_direction(x, &factor, u, sum, p, turned);
    factor.times(turned, sum, out);
    fired
}

/// Adds d(grad . L R u)/dX to `grad_x`.
#[inline(always)]
fn offset_vjp<T: Number>(x: &[T], u: &[T], buffers: &mut Buffers<T>, grad: &[T], grad_x: &mut [T]) {
    let k = x.len() / u.len();
    let n = u.len();
    let [e, pivots, sum, p, turned, grad_e, grad_turned, grad_p] =
        buffers.split([n * k, n, k, n, n, n * k, n, n]);
    let factor = Factor::new(x, e, pivots);
    let fired = clipped_direction(x, &factor, u, sum, p, turned);
    factor.bilinear_vjp((grad, turned), sum, grad_e, grad_x);
    if fired.total() > 0.0 {
        factor.transposed_times(grad, sum, grad_turned);
        turn_vjp((u, p, turned), fired, grad_turned, grad_p);
        factor.bilinear_vjp((u, grad_p), sum, grad_e, grad_x);
    }
    factor.directions_vjp(grad_e, grad_x);
}

/// Writes p = L'u and R u; returns 1 where the clip fired, else 0.
#[inline(always)]
fn clipped_direction<T: Number>(
    x: &[T],
    factor: &Factor<'_, T>,
    u: &[T],
    sum: &mut [T],
    p: &mut [T],
    turned: &mut [T],
) -> T {
    factor.transposed_times(u, sum, p);
    let std = dot(p, p).sqrt();
    let rounding = rounding(x.chunks_exact(sum.len()), u);
    for p in p.iter_mut() {
        *p = T::if_less(rounding, std, *p, T::all(0.0));
    }
    turn(u, p, turned)
}
