//! The bound that ignores correlations: every objective's own standard deviation.

use super::vector::rms;
use super::{Deviations, Ellipsoid, Work};

/// `mean_i + step * sigma_i u_i`, with sigma_i the objective's marginal standard deviation (paper Table B.1, "diagonal";
/// its "eigenvalues" are to be read as variances).
///
/// An objective on which all critics agree has the kink of |x| at zero; its gradient is the mean's.
#[derive(Clone, Copy, Debug, Default)]
pub struct Diagonal;

impl Ellipsoid for Diagonal {
    fn name(&self) -> &'static str {
        "diagonal"
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], _work: &mut Work, out: &mut [f64]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = x.std(i) * u[i];
        }
    }

    fn offset_vjp(&self, x: &Deviations<'_>, u: &[f64], _work: &mut Work, grad: &[f64], grad_x: &mut [f64]) {
        let critics = x.critics();
        for (i, (x, grad_x)) in x.iter().zip(grad_x.chunks_exact_mut(critics)).enumerate() {
            let std = rms(x);
            if std > 0.0 {
                let slope = grad[i] * u[i] / critics as f64;
                // Division first: x_ki / sigma_i is exactly +-1 for two critics.
                x.iter().zip(grad_x).for_each(|(x, grad_x)| *grad_x += slope * (x / std));
            }
        }
    }
}
