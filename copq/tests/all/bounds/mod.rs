//! What the tests of the projections share: random ensembles, textbook formulas, and short ways to
//! call.

#![allow(dead_code)]

use copq::projection::{
    BoundQuery, Cholesky, Deviations, Diagonal, Eigen, Ellipsoid, Extremum, IndependentMin,
    MeanStd, Projection, QView, ScalarisedMin, Scratch, Work,
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// Critics x objectives of one row, with weights and the gradient of the bound.
#[derive(Clone, Debug)]
pub struct Ensemble {
    pub critics: usize,
    pub q: Vec<f32>,
    pub weights: Vec<f32>,
    pub grad: Vec<f32>,
}

/// One to eight critics, one to five objectives of different scales; half of them made to disagree
/// in opposite ways.
///
/// Values are short binary fractions: moving or scaling them by such numbers is exact in f32.
pub fn ensembles() -> impl Strategy<Value = Ensemble> {
    shaped(1..=5, 1..=8)
}

/// Ensembles with at least N + 1 critics, as the methods are meant to be used.
pub fn full_ensembles() -> impl Strategy<Value = Ensemble> {
    (1..=5_usize, 1..=4_usize).prop_flat_map(|(n, spare)| shaped(n..=n, n + spare..=n + spare))
}

pub fn shaped(
    objectives: std::ops::RangeInclusive<usize>,
    critics: std::ops::RangeInclusive<usize>,
) -> impl Strategy<Value = Ensemble> {
    (objectives, critics, any::<bool>()).prop_flat_map(|(n, k, opposed)| {
        let values = prop::collection::vec(-640..=640_i32, n * k);
        let scales = prop::collection::vec(-4..=4_i32, n);
        let signs = prop::collection::vec(any::<bool>(), n);
        let sizes = prop::collection::vec(0.05..2.0_f32, n);
        let grad = prop::collection::vec(-2.0..2.0_f32, n);
        (values, scales, signs, sizes, grad).prop_map(
            move |(values, scales, signs, sizes, grad)| {
                let q = (0..n * k)
                    .map(|at| value(&values, n, at, opposed) * 2.0_f32.powi(scales[at % n]))
                    .collect();
                let sign = |negative: bool| if negative && !opposed { -1.0 } else { 1.0 };
                let weights = signs
                    .iter()
                    .zip(sizes)
                    .map(|(&negative, size)| sign(negative) * size)
                    .collect();
                Ensemble { critics: k, q, weights, grad }
            },
        )
    })
}

fn value(values: &[i32], n: usize, at: usize, opposed: bool) -> f32 {
    let own = values[at] as f32 / 64.0;
    let first = values[at / n * n] as f32 / 64.0;
    if opposed && !at.is_multiple_of(n) { own / 8.0 - first } else { own }
}

impl Ensemble {
    pub fn new(q: &[&[f32]], weights: &[f32]) -> Self {
        let grad = vec![1.0; weights.len()];
        Self { critics: q.len(), q: q.concat(), weights: weights.to_vec(), grad }
    }

    pub fn objectives(&self) -> usize {
        self.weights.len()
    }

    /// The unit direction.
    pub fn unit(&self) -> DVector<f64> {
        widen(&self.weights).normalize()
    }

    /// Critics x objectives.
    pub fn values(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.critics, self.objectives(), widen(&self.q).as_slice())
    }

    pub fn mean(&self) -> DVector<f64> {
        self.values().row_mean_tr()
    }

    /// X transposed: stored by column, it is X by row, as the library takes it.
    pub fn deviations(&self) -> DMatrix<f64> {
        centred(self.values())
    }

    /// Sigma by its definition.
    pub fn covariance(&self) -> DMatrix<f64> {
        let x = self.deviations();
        x.tr_mul(&x) / self.critics as f64
    }

    pub fn stds(&self) -> DVector<f64> {
        self.covariance().diagonal().map(f64::sqrt)
    }

    pub fn largest_std(&self) -> f64 {
        self.stds().max()
    }

    /// C R u in f64.
    pub fn offset(&self, method: &dyn Ellipsoid) -> DVector<f64> {
        offset(method, &self.deviations(), &self.unit())
    }

    /// C, by its columns: along an axis the Cholesky method never clips.
    pub fn factor(&self, method: &dyn Ellipsoid) -> DMatrix<f64> {
        let n = self.objectives();
        let axes = DMatrix::identity(n, n);
        let column = |axis| offset(method, &self.deviations(), &axes.column(axis).into_owned());
        DMatrix::from_columns(&(0..n).map(column).collect::<Vec<_>>())
    }

    /// u . L u with the library's own L: the clip fires where it is negative.
    pub fn margin(&self) -> f64 {
        self.unit().dot(&(self.factor(&Cholesky) * self.unit()))
    }

    pub fn bound(&self, method: &dyn Projection, step: f32) -> Vec<f32> {
        project(method, &self.q, self.critics, &self.weights, step)
    }

    pub fn gradient(&self, method: &dyn Projection, step: f32) -> Vec<f32> {
        vjp(method, &self.q, self.critics, &self.weights, step, &self.grad)
    }

    /// Whether the bound of every method is smooth around here: no pivot, clip or scalarised
    /// disagreement near zero.
    pub fn is_smooth(&self) -> bool {
        let u = self.unit();
        let stds = self.stds();
        let covariance = self.covariance();
        // Past the rank the factor's columns are zero, and a pivot is only rounding.
        let rank = self.objectives().min(self.critics - 1);
        let leading = covariance.view((0, 0), (rank, rank)).into_owned();
        let Some(low) = leading.cholesky().map(|factor| factor.l()) else { return false };
        let pivots = stds.min() > 0.0 && (0..rank).all(|j| low[(j, j)] > 0.1 * stds[j]);
        let p = low.solve_lower_triangular(&(covariance.rows(0, rank) * &u)).unwrap();
        let a = u.rows(0, rank).dot(&p);
        let rho = p.norm();
        pivots && a.abs() > 0.05 * rho && a.abs() < 0.98 * rho && rho > 0.2 * stds.max()
    }
}

/// Subtracts every objective's mean.
pub fn centred(mut q: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in q.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
    q
}

pub fn offset(method: &dyn Ellipsoid, x: &DMatrix<f64>, u: &DVector<f64>) -> DVector<f64> {
    let deviations = Deviations::new(x.as_slice(), x.nrows()).unwrap();
    let mut out = DVector::repeat(u.len(), f64::NAN);
    method.offset(&deviations, u.as_slice(), &mut Work::default(), out.as_mut_slice());
    out
}

pub fn offset_vjp(
    method: &dyn Ellipsoid,
    x: &DMatrix<f64>,
    u: &DVector<f64>,
    grad: &DVector<f64>,
) -> DMatrix<f64> {
    let deviations = Deviations::new(x.as_slice(), x.nrows()).unwrap();
    let mut out = DMatrix::zeros(x.nrows(), x.ncols());
    let (u, grad) = (u.as_slice(), grad.as_slice());
    method.offset_vjp(&deviations, u, &mut Work::default(), grad, out.as_mut_slice());
    out
}

pub fn project(
    method: &dyn Projection,
    q: &[f32],
    critics: usize,
    weights: &[f32],
    step: f32,
) -> Vec<f32> {
    project_rows(method, QView::new(q, critics, weights.len()).unwrap(), weights, step)
}

pub fn project_rows(method: &dyn Projection, q: QView<'_>, weights: &[f32], step: f32) -> Vec<f32> {
    let mut out = vec![f32::NAN; q.values().len() / q.critics()];
    method.project(BoundQuery { q, weights, step }, &mut Scratch::default(), &mut out).unwrap();
    out
}

pub fn vjp(
    method: &dyn Projection,
    q: &[f32],
    critics: usize,
    weights: &[f32],
    step: f32,
    grad: &[f32],
) -> Vec<f32> {
    vjp_rows(method, QView::new(q, critics, weights.len()).unwrap(), weights, step, grad)
}

pub fn vjp_rows(
    method: &dyn Projection,
    q: QView<'_>,
    weights: &[f32],
    step: f32,
    grad: &[f32],
) -> Vec<f32> {
    let mut out = vec![f32::NAN; q.values().len()];
    method.vjp(BoundQuery { q, weights, step }, &mut Scratch::default(), grad, &mut out).unwrap();
    out
}

pub fn ellipsoids() -> [&'static dyn Ellipsoid; 4] {
    [&Cholesky, &Eigen, &Extremum, &Diagonal]
}

/// All of the registry; CAL's with the length of the others.
pub fn projections() -> [&'static dyn Projection; 7] {
    [&Cholesky, &Eigen, &Extremum, &Diagonal, &ScalarisedMin, &IndependentMin, &MEAN_STD]
}

const MEAN_STD: MeanStd = MeanStd { cost: 1.0, reward: 1.0 };

/// R of paper A.2-A.4 as a matrix, for a direction in which the clip fires.
pub fn rotation(low: &DMatrix<f64>, u: &DVector<f64>) -> DMatrix<f64> {
    let p = low.tr_mul(u);
    let a = u.dot(&p);
    let v = (&p - a * u).normalize();
    let k = &v * u.transpose() - u * v.transpose();
    let sine = a / p.norm();
    let cosine = (1.0 - sine.powi(2)).sqrt();
    DMatrix::identity(u.len(), u.len()) - sine * &k + (1.0 - cosine) * &k * &k
}

pub fn widen(values: &[f32]) -> DVector<f64> {
    DVector::from_iterator(values.len(), values.iter().map(|&v| f64::from(v)))
}
