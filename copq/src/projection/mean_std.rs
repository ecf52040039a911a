//! Costs and rewards, each on the pessimistic side of its own mean, with separate lengths.

use super::diagonal::{along_axes, along_axes_vjp};
use super::{Deviations, Ellipsoid, Work};

/// `mean_i + step * k_i sigma_i sign(u_i)`, with one k for costs (negative weights) and one for
/// rewards. It ignores correlations and, unlike [`Diagonal`](super::Diagonal), the sizes of the
/// weights.
///
/// An objective on which all critics agree has the kink of |x| at zero; its gradient is the mean's.
///
/// ```
/// use copq::projection::{BoundQuery, MeanStd, Projection, QView, Scratch};
///
/// // Two critics of a cost and a reward: means 11 and 3, standard deviations 1 and 2.
/// let q = QView::new(&[10.0, 5.0, 12.0, 1.0], 2, 2)?;
/// let bounds = MeanStd { cost: 0.5, reward: 1.0 };
/// for weights in [[-1.0, 1.0], [-0.1, 7.0]] {
///     let mut out = [0.0; 2];
///     let bound = BoundQuery { q, weights: &weights, step: -1.0 };
///     bounds.project(bound, &mut Scratch::default(), &mut out)?;
///     assert_eq!(out, [11.5, 1.0]); // whatever the weights' sizes
/// }
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanStd {
    /// Standard deviations (over K, not K - 1) for a cost.
    pub cost: f64,
    /// Standard deviations for a reward; 1 makes it the smaller of two critics.
    pub reward: f64,
}

impl Default for MeanStd {
    /// CAL's bounds, following its authors' code: 0.5 unbiased deviations of four cost critics, and
    /// one deviation of each reward.
    fn default() -> Self {
        Self::cal(0.5, 4)
    }
}

impl MeanStd {
    /// CAL's bounds (Wu et al. 2024): `mean + k std` of `critics` cost critics, with their unbiased
    /// standard deviation (over K - 1), and the smaller of two reward critics. The authors' code
    /// uses k = 0.5, with 4 cost critics.
    pub fn cal(k: f64, critics: usize) -> Self {
        let unbiased = (critics as f64 / critics.saturating_sub(1).max(1) as f64).sqrt();
        Self { cost: k * unbiased, reward: 1.0 }
    }

    /// The signed length for an objective; a weight of -0 is still a cost's.
    fn length(self, u: f64) -> f64 {
        if u.is_sign_negative() { -self.cost } else { self.reward }
    }
}

impl Ellipsoid for MeanStd {
    fn name(&self) -> &'static str {
        "mean-std"
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], _work: &mut Work, out: &mut [f64]) {
        along_axes(x, |i| self.length(u[i]), out);
    }

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        _work: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        along_axes_vjp(x, |i| self.length(u[i]), grad, grad_x);
    }
}
