//! The bound by the symmetric square root of the critics' covariance.

use super::jacobi;
use super::preconditioned::Factors;
use super::vector::{add_scaled, dot};
use super::{Deviations, Ellipsoid, Work};

/// `mean + step * Sigma^(1/2) u`, with the symmetric positive root V S V' (paper Table B.1,
/// "eigen", eigenvectors as the columns of V). No objective has priority over another.
///
/// Where Sigma has a zero eigenvalue that a change of the critics could make positive, the root has
/// a kink like |x| at zero; that eigenvalue passes no gradient on.
///
/// With more than eight objectives the last bits depend on the width of the processor's vectors.
///
/// ```
/// use copq::projection::{BoundQuery, Eigen, Projection, QView, Scratch};
///
/// let bound = |q: &[f32]| -> copq::Result<[f32; 2]> {
///     let mut low = [0.0; 2];
///     let bound = BoundQuery { q: QView::new(q, 3, 2)?, weights: &[1.0, 1.0], step: -1.0 };
///     Eigen.project(bound, &mut Scratch::default(), &mut low)?;
///     Ok(low)
/// };
/// // Three critics of two objectives, in one order and in the other: the bound is the same.
/// let [first, second] = bound(&[10.0, 5.0, 12.0, -4.0, 11.0, 2.0])?;
/// assert!((first - 11.312164).abs() < 1e-5 && (second + 1.058125).abs() < 1e-5);
/// let swapped = bound(&[5.0, 10.0, -4.0, 12.0, 2.0, 11.0])?;
/// assert!((swapped[0] - second).abs() < 1e-5 && (swapped[1] - first).abs() < 1e-5);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Eigen;

/// With more objectives than this, a QR before the rotations is worthwhile.
const FEW: usize = 8;

impl Ellipsoid for Eigen {
    fn name(&self) -> &'static str {
        "eigen"
    }

    fn reads_covariances(&self) -> bool {
        true
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], work: &mut Work, out: &mut [f64]) {
        let k = x.critics();
        let n = x.objectives();
        let ([s, z, v], factors) = work.split_beside([n, n * k, n * n]);
        decompose(x, factors, s, z, v);
        out.fill(0.0);
        for (s, v) in s.iter().zip(v.chunks_exact(n)) {
            add_scaled(out, s * dot(v, u), v);
        }
    }

    /// With S dS + dS S = dSigma and Sigma = X'X / K, and M = V' (grad u' + u grad') V / 2, the
    /// gradient is (2 / K) sum_ij z_i [s_i M_ij / (s_i + s_j)] v_j', in which nothing exceeds M.
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
        let ([s, z, v, u_v, grad_v, sum], factors) = work.split_beside([n, n * k, n * n, n, n, k]);
        decompose(x, factors, s, z, v);
        for (i, v) in v.chunks_exact(n).enumerate() {
            u_v[i] = dot(v, u);
            grad_v[i] = dot(v, grad);
        }
        for (j, v) in v.chunks_exact(n).enumerate() {
            sum.fill(0.0);
            for (i, z) in z.chunks_exact(k).enumerate().filter(|&(i, _)| s[i] > 0.0) {
                let twice_m = grad_v[i] * u_v[j] + u_v[i] * grad_v[j];
                add_scaled(sum, s[i] / (s[i] + s[j]) * twice_m / k as f64, z);
            }
            for (v, grad_x) in v.iter().zip(grad_x.chunks_exact_mut(k)) {
                add_scaled(grad_x, *v, sum);
            }
        }
    }
}

/// X / sqrt(K) = Z S V', as computed by [`jacobi::decompose`].
fn decompose(
    x: &Deviations<'_>,
    factors: &mut Factors,
    s: &mut [f64],
    z: &mut [f64],
    v: &mut [f64],
) {
    if x.objectives() <= FEW || !factors.decompose(x, s, z, v) {
        jacobi::decompose(x, s, z, v);
    }
}
