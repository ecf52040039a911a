//! Confidence ellipsoids: methods that move from the mean along `C R u`, with C a square-root-like
//! factor of Sigma.

use std::fmt::Debug;

use super::{BoundQuery, Deviations, Projection, Scratch, Work};
use crate::Result;

/// A projection of the form `mean + step * C R u` (paper App. B), defined by its offset alone.
///
/// Every `Ellipsoid` is a [`Projection`]: a blanket impl adds checks, unit directions, centring,
/// the mean and its gradient. An offset sees one row at a time, in double precision, and must
/// depend only on the deviations.
///
/// ```
/// use copq::projection::{BoundQuery, Deviations, Ellipsoid, Projection, QView, Scratch, Work};
///
/// /// Half of each objective's own standard deviation: a milder `Diagonal`.
/// #[derive(Debug)]
/// struct Half;
///
/// impl Ellipsoid for Half {
///     fn name(&self) -> &'static str {
///         "half"
///     }
///     fn offset(&self, x: &Deviations<'_>, u: &[f64], _: &mut Work, out: &mut [f64]) {
///         for (i, out) in out.iter_mut().enumerate() {
///             *out = 0.5 * x.std(i) * u[i];
///         }
///     }
///     fn offset_vjp(
///         &self,
///         x: &Deviations<'_>,
///         u: &[f64],
///         _: &mut Work,
///         grad: &[f64],
///         grad_x: &mut [f64],
///     ) {
///         let k = x.critics();
///         for (i, grad_x) in grad_x.chunks_exact_mut(k).enumerate() {
///             if x.std(i) > 0.0 {
///                 let slope = 0.5 * grad[i] * u[i] / (x.std(i) * k as f64);
///                 grad_x.iter_mut().zip(x.objective(i)).for_each(|(grad_x, x)| *grad_x += slope * x);
///             }
///         }
///     }
/// }
///
/// // Two critics that value two objectives (1, 10) and (3, 20); only the first objective has a
/// // weight.
/// let q = QView::new(&[1.0, 10.0, 3.0, 20.0], 2, 2)?;
/// let mut low = [0.0; 2];
/// let bound = BoundQuery { q, weights: &[1.0, 0.0], step: -1.0 };
/// Half.project(bound, &mut Scratch::default(), &mut low)?;
/// assert_eq!(low, [1.5, 15.0]);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Ellipsoid: Debug + Send + Sync {
    /// See [`Projection::name`].
    fn name(&self) -> &'static str;

    /// See [`Projection::reads_covariances`].
    fn reads_covariances(&self) -> bool {
        false
    }

    /// Writes C R u (N) for the unit direction `u`. `out` may hold anything beforehand. Zero
    /// disagreement gives exactly zero.
    fn offset(&self, x: &Deviations<'_>, u: &[f64], work: &mut Work, out: &mut [f64]);

    /// Adds d(grad . C R u)/dX to `grad_x`, which is laid out `objectives x critics` like
    /// [`Deviations::values`] and is zero beforehand; u is constant. A part that is the same for
    /// all critics is removed afterwards, because X is centred.
    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        work: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    );
}

impl<E: Ellipsoid> Projection for E {
    fn name(&self) -> &'static str {
        Ellipsoid::name(self)
    }

    fn reads_covariances(&self) -> bool {
        Ellipsoid::reads_covariances(self)
    }

    fn project(&self, bound: BoundQuery<'_>, scratch: &mut Scratch, out: &mut [f32]) -> Result<()> {
        let directions = bound.check(out)?;
        let BoundQuery { q, step, .. } = bound;
        let (row, work) = scratch.parts();
        let mut clips = 0;
        row.resize(q);
        for at in 0..q.rows() {
            row.load(q, &directions, at);
            let x = Deviations::of(&row.deviations, q.critics());
            self.offset(&x, &row.unit, work, &mut row.offset);
            clips += usize::from(work.take_clip());
            row.write_bound(at, step.into(), out);
        }
        scratch.report_clips(clips, q.rows());
        Ok(())
    }

    fn vjp(
        &self,
        bound: BoundQuery<'_>,
        scratch: &mut Scratch,
        grad_out: &[f32],
        grad_q: &mut [f32],
    ) -> Result<()> {
        let directions = bound.check_vjp(grad_out, grad_q)?;
        let BoundQuery { q, step, .. } = bound;
        let (row, work) = scratch.parts();
        row.resize(q);
        for at in 0..q.rows() {
            row.load(q, &directions, at);
            row.load_grad(at, grad_out);
            let x = Deviations::of(&row.deviations, q.critics());
            self.offset_vjp(&x, &row.unit, work, &row.grad, &mut row.grad_x);
            row.write_grad(q, at, step.into(), grad_q);
        }
        work.take_clip();
        Ok(())
    }
}
