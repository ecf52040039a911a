//! The bound that ignores correlations: every objective's own standard deviation.

use super::vector::rms;
use super::{Deviations, Ellipsoid, Work};

/// `mean_i + step * sigma_i u_i`, with sigma_i the objective's marginal standard deviation (paper
/// Table B.1, "diagonal"; its "eigenvalues" are to be read as variances).
///
/// An objective on which all critics agree has the kink of |x| at zero; its gradient is the mean's.
///
/// ```
/// use copq::projection::{BoundQuery, Diagonal, Projection, QView, Scratch};
///
/// // Two critics, two objectives. First they rise together, then one rises as the other falls.
/// let mut low = [[0.0; 2]; 2];
/// for (low, q) in low.iter_mut().zip([[1.0, 1.0, 3.0, 5.0], [1.0, 5.0, 3.0, 1.0]]) {
///     let bound = BoundQuery { q: QView::new(&q, 2, 2)?, weights: &[3.0, 4.0], step: -1.0 };
///     Diagonal.project(bound, &mut Scratch::default(), low)?;
/// }
/// // Means 2 and 3, less 0.6 and 0.8 of the standard deviations 1 and 2.
/// assert_eq!(low, [[1.4; 2]; 2]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Diagonal;

impl Ellipsoid for Diagonal {
    fn name(&self) -> &'static str {
        "diagonal"
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], _work: &mut Work, out: &mut [f64]) {
        along_axes(x, |i| u[i], out);
    }

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        _work: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        along_axes_vjp(x, |i| u[i], grad, grad_x);
    }
}

/// Writes every objective's own standard deviation times a length.
pub(super) fn along_axes(x: &Deviations<'_>, length: impl Fn(usize) -> f64, out: &mut [f64]) {
    out.iter_mut().enumerate().for_each(|(i, out)| *out = x.std(i) * length(i));
}

/// Adds the gradient of `grad . along_axes` to `grad_x`; nothing where all critics agree.
pub(super) fn along_axes_vjp(
    x: &Deviations<'_>,
    length: impl Fn(usize) -> f64,
    grad: &[f64],
    grad_x: &mut [f64],
) {
    let critics = x.critics();
    for (i, (x, grad_x)) in x.iter().zip(grad_x.chunks_exact_mut(critics)).enumerate() {
        let std = rms(x);
        if std > 0.0 {
            let slope = grad[i] * length(i) / critics as f64;
            // Division first: x_ki / sigma_i is exactly +-1 for two critics.
            x.iter().zip(grad_x).for_each(|(x, grad_x)| *grad_x += slope * (x / std));
        }
    }
}
