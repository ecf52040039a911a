//! X, the critics' deviations from their mean in one row: what an ellipsoid is made of.

use super::vector::{add_scaled, dot, rms, sum};
use crate::{Error, Result};

/// A standard deviation below this multiple of the numbers that it was computed from is only their
/// rounding error, and counts as zero.
///
/// It lies half-way, in digits, between what double precision leaves of an exact zero (1e-16) and
/// the smallest disagreement that single-precision critics can express (1e-8).
pub const ROUNDING: f64 = 1e-12;

/// The centred values x_ki = Q_ki - mean_i of one row. The covariance is Sigma = X'X / K (biased,
/// paper sec. 4.3).
///
/// ```
/// use copq::projection::Deviations;
///
/// // Two critics, two objectives about which they disagree in opposite ways.
/// let x = Deviations::new(&[-1.0, 1.0, 2.0, -2.0], 2)?;
/// assert_eq!((x.std(0), x.std(1)), (1.0, 2.0));
///
/// let mut covariance = [0.0; 2]; // of each objective with the first
/// x.covariance(x.objective(0), &mut covariance);
/// assert_eq!(covariance, [1.0, -2.0]);
///
/// let mut total = [0.0; 2]; // of the value 2 q_1 + q_2 all say the same
/// x.scalarised(&[2.0, 1.0], &mut total);
/// assert_eq!(total, [0.0, 0.0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Deviations<'a> {
    values: &'a [f64],
    critics: usize,
}

impl<'a> Deviations<'a> {
    /// Views `objectives x critics` values, which the caller has centred: the values of each
    /// objective sum to zero.
    pub fn new(values: &'a [f64], critics: usize) -> Result<Self> {
        if critics == 0 || values.is_empty() || !values.len().is_multiple_of(critics) {
            let wanted = format!("a positive multiple of {critics} critics");
            return Err(Error::invalid("deviations", wanted, values.len()));
        }
        Ok(Self { values, critics })
    }

    /// For values whose shape is right by construction.
    pub(super) fn of(values: &'a [f64], critics: usize) -> Self {
        Self { values, critics }
    }

    /// K, the number of critics.
    pub fn critics(&self) -> usize {
        self.critics
    }

    /// N, the number of objectives.
    pub fn objectives(&self) -> usize {
        self.values.len() / self.critics
    }

    /// All values, `objectives x critics`.
    pub fn values(&self) -> &'a [f64] {
        self.values
    }

    /// x_i, one objective's K deviations.
    pub fn objective(&self, i: usize) -> &'a [f64] {
        &self.values[i * self.critics..(i + 1) * self.critics]
    }

    /// Every objective's deviations, in priority order.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &'a [f64]> + ExactSizeIterator {
        self.values.chunks_exact(self.critics)
    }

    /// sigma_i = sqrt(Sigma_ii), one objective's standard deviation.
    pub fn std(&self, i: usize) -> f64 {
        rms(self.objective(i))
    }

    /// Writes X u, the deviations of the scalarised value, into `out` (K).
    pub fn scalarised(&self, u: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (x, &u) in self.iter().zip(u) {
            add_scaled(out, u, x);
        }
    }

    /// Writes X'w / K into `out` (N): each objective's covariance with w over the critics.
    pub fn covariance(&self, w: &[f64], out: &mut [f64]) {
        for (out, x) in out.iter_mut().zip(self.iter()) {
            *out = dot(x, w) / self.critics as f64;
        }
    }

    /// Whether `std`, the computed sqrt(u' Sigma u), is only the rounding error of its terms u_i
    /// x_i.
    pub fn is_rounding(&self, u: &[f64], std: f64) -> bool {
        std <= ROUNDING * sum(self.iter().zip(u).map(|(x, u)| u.abs() * rms(x)))
    }
}
