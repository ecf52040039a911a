//! For inspection: what an ensemble says about one action, as matrices (feature `nalgebra`).

use nalgebra::{DMatrix, DVector};

use super::{BoundQuery, Projection, QView, Scratch};
use crate::error::check_len;
use crate::{Error, Result};

/// Mean values of one row, and how its critics disagree about them.
///
/// ```
/// use copq::projection::{Disagreement, QView};
///
/// // Three critics, two objectives: those that promise more safety promise less speed.
/// let q = [10.0, 5.0,  12.0, 4.0,  11.0, 3.0];
/// let row = Disagreement::of(QView::new(&q, 3, 2)?, 0)?;
/// assert!((row.mean()[0] - 11.0).abs() < 1e-12);
/// assert!((row.covariance()[(0, 1)] + 1.0 / 3.0).abs() < 1e-12);
///
/// // L, the Cholesky factor in priority order: L L' is the covariance.
/// let l = row.factor();
/// assert!((&l * l.transpose() - row.covariance()).norm() < 1e-12 && l[(0, 1)] == 0.0);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Disagreement {
    mean: DVector<f64>,
    /// X', `objectives x critics`.
    deviations: DMatrix<f64>,
    q: Vec<f32>,
}

impl Disagreement {
    /// The disagreement in one row of a batch of critics' values.
    pub fn of(q: QView<'_>, row: usize) -> Result<Self> {
        if row >= q.rows() {
            return Err(Error::invalid("row", format!("less than {}", q.rows()), row));
        }
        let critics = q.critics();
        let objectives = q.objectives();
        let values = DMatrix::from_fn(objectives, critics, |i, k| f64::from(q.get(k, row)[i]));
        let mean = values.column_mean();
        let mut deviations = values;
        for mut critic in deviations.column_iter_mut() {
            critic -= &mean;
        }
        let q = (0..critics).flat_map(|k| q.get(k, row)).copied().collect();
        Ok(Self { mean, deviations, q })
    }

    /// The disagreement of N + 1 critics, the fewest that have a mean (N) and the covariance of a
    /// factor L (N x N, lower triangular, L L' = Sigma). For pictures of what a projection does.
    ///
    /// ```
    /// use copq::projection::Disagreement;
    /// use nalgebra::{dmatrix, dvector};
    ///
    /// let factor = dmatrix![1.0, 0.0; -0.5, 2.0];
    /// let row = Disagreement::with_factor(&dvector![10.0, 5.0], &factor)?;
    /// assert!((row.covariance() - &factor * factor.transpose()).norm() < 1e-6);
    /// assert!((row.factor() - factor).norm() < 1e-6);
    /// # Ok::<(), copq::Error>(())
    /// ```
    pub fn with_factor(mean: &DVector<f64>, factor: &DMatrix<f64>) -> Result<Self> {
        let n = mean.len();
        check_len("rows of a factor", factor.nrows(), n)?;
        check_len("columns of a factor", factor.ncols(), n)?;
        let critics = n + 1;
        // Helmert's corners of a simplex: their mean is 0 and their covariance the identity.
        let corners = DMatrix::from_fn(n, critics, |i, k| {
            let size = (critics as f64 / ((i + 1) * (i + 2)) as f64).sqrt();
            match k {
                k if k <= i => size,
                k if k == i + 1 => -size * (i + 1) as f64,
                _ => 0.0,
            }
        });
        let mut values = factor * corners;
        for mut critic in values.column_iter_mut() {
            critic += mean;
        }
        let q: Vec<f32> = values.iter().map(|&value| value as f32).collect();
        Self::of(QView::new(&q, critics, n)?, 0)
    }

    /// The critics' values, one point each (N).
    pub fn critics(&self) -> impl Iterator<Item = &[f32]> {
        self.q.chunks_exact(self.mean.len())
    }

    /// The critics' mean value of each objective (N).
    pub fn mean(&self) -> &DVector<f64> {
        &self.mean
    }

    /// Sigma = X'X / K (N x N), biased as in the paper's sec. 4.3.
    pub fn covariance(&self) -> DMatrix<f64> {
        let critics = self.deviations.ncols() as f64;
        &self.deviations * self.deviations.transpose() / critics
    }

    /// L (N x N), lower triangular with a diagonal that is not negative, so that L L' is the
    /// covariance. Row i is conditioned only on the objectives above it. Computed by QR of X, which
    /// squares no rounding error.
    pub fn factor(&self) -> DMatrix<f64> {
        let (objectives, critics) = self.deviations.shape();
        let scaled = self.deviations.transpose() / (critics as f64).sqrt();
        let r = scaled.qr().r();
        let mut factor = DMatrix::zeros(objectives, objectives);
        for i in 0..r.nrows() {
            let sign = if r[(i, i)] < 0.0 { -1.0 } else { 1.0 };
            for j in i..objectives {
                factor[(j, i)] = sign * r[(i, j)];
            }
        }
        factor
    }

    /// The bound that a projection gives for these critics (N), `step` from the mean.
    pub fn bound(
        &self,
        projection: &dyn Projection,
        weights: &[f32],
        step: f32,
    ) -> Result<DVector<f64>> {
        let mut out = vec![0.0; self.mean.len()];
        let q = QView::new(&self.q, self.deviations.ncols(), self.mean.len())?;
        projection.project(BoundQuery { q, weights, step }, &mut Scratch::default(), &mut out)?;
        Ok(DVector::from_iterator(out.len(), out.into_iter().map(f64::from)))
    }

    /// The edge of the confidence ellipse of two objectives: `points` points where (q - mean)'
    /// Sigma^-1 (q - mean) is `radius` squared, with Sigma the covariance of the two.
    pub fn ellipse(
        &self,
        objectives: [usize; 2],
        radius: f64,
        points: usize,
    ) -> Result<Vec<[f64; 2]>> {
        let n = self.mean.len();
        if let Some(&unknown) = objectives.iter().find(|&&i| i >= n) {
            return Err(Error::invalid(
                "objective of an ellipse",
                format!("less than {n}"),
                unknown,
            ));
        }
        check_len(
            "objectives of an ellipse that differ",
            usize::from(objectives[0] != objectives[1]) + 1,
            2,
        )?;
        let pair = Self {
            mean: self.mean.select_rows(&objectives),
            deviations: self.deviations.select_rows(&objectives),
            q: Vec::new(),
        };
        let factor = pair.factor();
        let at = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / points as f64;
            let edge = &pair.mean
                + &factor * DVector::from_vec(vec![radius * angle.cos(), radius * angle.sin()]);
            [edge[0], edge[1]]
        };
        Ok((0..points).map(at).collect())
    }
}
