//! What a projection is asked for: which critics' values, which weights, how far from the mean.

use super::{Directions, QView};
use crate::error::check_len;
use crate::{Error, Result};

/// The bound that is asked for: `critics' mean + step * offset(u)`, row by row.
///
/// ```
/// use copq::projection::{BoundQuery, Cholesky, Projection, QView, Scratch};
///
/// // Two critics of one objective say 2 and 5: the mean is 3.5, the standard deviation 1.5.
/// let q = QView::new(&[2.0, 5.0], 2, 1)?;
/// for (step, wanted) in [(-1.0, 2.0), (0.0, 3.5), (2.0, 6.5)] {
///     let mut out = [0.0];
///     let bound = BoundQuery { q, weights: &[1.0], step };
///     Cholesky.project(bound, &mut Scratch::default(), &mut out)?;
///     assert_eq!(out, [wanted]);
/// }
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BoundQuery<'a> {
    /// The critics' values, `critics x rows x objectives`.
    pub q: QView<'a>,
    /// Raw scalarisation weights w, one per objective (`N`) or one set per row (`B x N`). They give
    /// the direction u = w / |w|.
    pub weights: &'a [f32],
    /// Signed length: -1 is the lower bound for the TD target and the actor (paper eq. 11), 0 the
    /// mean, +beta the upper bound for exploration (eq. 12).
    pub step: f32,
}

impl<'a> BoundQuery<'a> {
    /// Checks everything that [`Projection::project`](super::Projection::project) is given; returns
    /// the directions.
    pub fn check(self, out: &[f32]) -> Result<Directions<'a>> {
        self.check_rows("bound", out)
    }

    /// Checks everything that [`Projection::vjp`](super::Projection::vjp) is given; returns the
    /// directions.
    pub fn check_vjp(self, grad_out: &[f32], grad_q: &[f32]) -> Result<Directions<'a>> {
        let directions = self.check_rows("gradient of the bound", grad_out)?;
        check_len("gradient of the critic values", grad_q.len(), self.q.values().len())?;
        Ok(directions)
    }

    fn check_rows(self, what: &str, values: &[f32]) -> Result<Directions<'a>> {
        if !self.step.is_finite() {
            return Err(Error::invalid("step of the bound", "a finite number", self.step));
        }
        check_len(what, values.len(), self.q.rows() * self.q.objectives())?;
        Directions::new(self.weights, self.q.rows(), self.q.objectives())
    }
}
