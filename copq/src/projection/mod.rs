//! From an ensemble of vector-valued critics to one confidence bound: K x B x N values in, B x N
//! out.

mod bound;
mod check;
mod cholesky;
mod clip;
mod confidence;
mod deviations;
mod diagonal;
mod directions;
#[cfg(feature = "nalgebra")]
mod disagreement;
mod eigen;
mod ellipsoid;
mod extremum;
mod factor;
mod gram_schmidt;
mod independent_min;
mod jacobi;
mod mean_std;
mod preconditioned;
mod registry;
mod row;
mod scalarised_min;
mod scratch;
mod selection;
mod vector;
mod view;

use std::fmt::Debug;
use std::sync::Arc;

pub use bound::BoundQuery;
pub use check::check_projection;
pub use cholesky::Cholesky;
pub use confidence::{confidence, step_length};
pub use deviations::Deviations;
pub use diagonal::Diagonal;
pub use directions::Directions;
#[cfg(feature = "nalgebra")]
pub use disagreement::Disagreement;
pub use eigen::Eigen;
pub use ellipsoid::Ellipsoid;
pub use extremum::Extremum;
pub use independent_min::IndependentMin;
pub use mean_std::MeanStd;
pub use registry::{by_name, names};
pub use scalarised_min::ScalarisedMin;
pub use scratch::{Scratch, Work};
pub use view::QView;

use crate::{Ensemble, Result};

/// A rule that turns the critics' disagreement into one vector per row: `mean + step * offset` for
/// ellipsoid methods.
///
/// A [`BoundQuery`] says what is asked for: values, weights (one set for all rows, or one per row)
/// and a signed step. A zero or non-finite set of weights is an error.
///
/// The same input gives the same output, bit for bit. A NaN among the critics' values makes the
/// bound of its objective NaN. Finding it is left to the caller, who knows the objective's name.
///
/// Its `Debug` text identifies the projection and its settings in a checkpoint. A run resumes only
/// with a projection of the same text, so the text must show nothing that changes.
///
/// Your own method is either an [`Ellipsoid`], which only has to say how far from the mean to go,
/// or a full `Projection`. The latter starts with [`BoundQuery::check`] or
/// [`BoundQuery::check_vjp`].
///
/// ```
/// use copq::projection::{BoundQuery, Cholesky, Projection, QView, Scratch};
///
/// // Two critics value one state-action pair, one objective: the lower bound is clipped
/// // double-Q's minimum.
/// let bound = BoundQuery { q: QView::new(&[2.0, 5.0], 2, 1)?, weights: &[1.0], step: -1.0 };
/// let mut scratch = Scratch::default();
///
/// let mut low = [0.0];
/// Cholesky.project(bound, &mut scratch, &mut low)?;
/// assert_eq!(low, [2.0]);
///
/// let mut grad = [0.0; 2];
/// Cholesky.vjp(bound, &mut scratch, &[1.0], &mut grad)?;
/// assert_eq!(grad, [1.0, 0.0]);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Projection: Debug + Send + Sync {
    /// The method's name on command lines and in logs.
    fn name(&self) -> &'static str;

    /// The critics that the method is meant to be used with; by default, N + 1 critics of all N
    /// values.
    fn ensemble(&self) -> Ensemble {
        Ensemble::Spanning
    }

    /// Whether it reads covariances between objectives. These mean nothing for separate critics, so
    /// a learner refuses the combination.
    fn reads_covariances(&self) -> bool {
        false
    }

    /// Writes the bound, `rows x objectives`, into `out`.
    fn project(&self, bound: BoundQuery<'_>, scratch: &mut Scratch, out: &mut [f32]) -> Result<()>;

    /// Writes d(grad_out . bound)/dq, laid out like `bound.q`, into `grad_q`; weights are
    /// constants.
    fn vjp(
        &self,
        bound: BoundQuery<'_>,
        scratch: &mut Scratch,
        grad_out: &[f32],
        grad_q: &mut [f32],
    ) -> Result<()>;
}

/// A method chosen at run time, for example with [`by_name`], or shared by several learners
/// ([`Method::bound`](crate::Method::bound)).
impl Projection for Arc<dyn Projection> {
    fn name(&self) -> &'static str {
        self.as_ref().name()
    }

    fn ensemble(&self) -> Ensemble {
        self.as_ref().ensemble()
    }

    fn reads_covariances(&self) -> bool {
        self.as_ref().reads_covariances()
    }

    fn project(&self, bound: BoundQuery<'_>, scratch: &mut Scratch, out: &mut [f32]) -> Result<()> {
        self.as_ref().project(bound, scratch, out)
    }

    fn vjp(
        &self,
        bound: BoundQuery<'_>,
        scratch: &mut Scratch,
        grad_out: &[f32],
        grad_q: &mut [f32],
    ) -> Result<()> {
        self.as_ref().vjp(bound, scratch, grad_out, grad_q)
    }
}
