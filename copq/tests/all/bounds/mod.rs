//! What the tests of the projections share: random ensembles, textbook formulas, and short ways to
//! call.

#![allow(dead_code)]

use copq::projection::{
    Bound, Cholesky, Deviations, Diagonal, Eigen, Ellipsoid, Extremum, IndependentMin, MeanStd,
    Projection, QView, ScalarisedMin, Scratch, Work,
};
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
    pub fn unit(&self) -> Vec<f64> {
        let norm = self.weights.iter().map(|&w| f64::from(w).powi(2)).sum::<f64>().sqrt();
        self.weights.iter().map(|&w| f64::from(w) / norm).collect()
    }

    pub fn mean(&self) -> Vec<f64> {
        let column = |i| self.q.iter().skip(i).step_by(self.objectives()).map(|&q| f64::from(q));
        (0..self.objectives()).map(|i| column(i).sum::<f64>() / self.critics as f64).collect()
    }

    /// X, objectives x critics.
    pub fn deviations(&self) -> Vec<f64> {
        let values = self.q.iter().map(|&q| f64::from(q)).collect::<Vec<_>>();
        centred(&values, self.objectives())
    }

    /// Sigma by its definition.
    pub fn covariance(&self) -> Vec<Vec<f64>> {
        let x = self.deviations();
        let columns: Vec<&[f64]> = x.chunks_exact(self.critics).collect();
        let entry = |a: &[f64], b: &[f64]| dot(a, b) / self.critics as f64;
        columns.iter().map(|a| columns.iter().map(|b| entry(a, b)).collect()).collect()
    }

    pub fn stds(&self) -> Vec<f64> {
        let covariance = self.covariance();
        (0..self.objectives()).map(|i| covariance[i][i].sqrt()).collect()
    }

    pub fn largest_std(&self) -> f64 {
        self.stds().into_iter().fold(0.0, f64::max)
    }

    /// C R u in f64.
    pub fn offset(&self, method: &dyn Ellipsoid) -> Vec<f64> {
        offset(method, &self.deviations(), self.critics, &self.unit())
    }

    /// C, by its columns: along an axis the Cholesky method never clips.
    pub fn factor(&self, method: &dyn Ellipsoid) -> Vec<Vec<f64>> {
        let n = self.objectives();
        let axis = |j| (0..n).map(|i| f64::from(u8::from(i == j))).collect::<Vec<_>>();
        let columns: Vec<_> =
            (0..n).map(|j| offset(method, &self.deviations(), self.critics, &axis(j))).collect();
        (0..n).map(|i| (0..n).map(|j| columns[j][i]).collect()).collect()
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
        let low = cholesky(&self.covariance());
        let u = self.unit();
        let rank = self.objectives().min(self.critics - 1);
        let pivots = self
            .stds()
            .iter()
            .enumerate()
            .all(|(j, &std)| std > 0.0 && (j >= rank || low[j][j] > 0.1 * std));
        let p = transposed_times(&low, &u);
        let a = dot(&u, &p);
        let rho = dot(&p, &p).sqrt();
        pivots && a.abs() > 0.05 * rho && a.abs() < 0.98 * rho && rho > 0.2 * self.largest_std()
    }
}

/// Subtracts every objective's mean; critics x objectives to objectives x critics.
pub fn centred(q: &[f64], objectives: usize) -> Vec<f64> {
    let critics = q.len() / objectives;
    let column = |i| q.iter().skip(i).step_by(objectives).copied();
    let centre = |i| column(i).map(move |q| q - column(i).sum::<f64>() / critics as f64);
    (0..objectives).flat_map(centre).collect()
}

pub fn offset(method: &dyn Ellipsoid, x: &[f64], critics: usize, u: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; u.len()];
    method.offset(&Deviations::new(x, critics).unwrap(), u, &mut Work::default(), &mut out);
    out
}

pub fn offset_vjp(
    method: &dyn Ellipsoid,
    x: &[f64],
    critics: usize,
    u: &[f64],
    grad: &[f64],
) -> Vec<f64> {
    let mut out = vec![0.0; x.len()];
    method.offset_vjp(
        &Deviations::new(x, critics).unwrap(),
        u,
        &mut Work::default(),
        grad,
        &mut out,
    );
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
    method.project(Bound { q, weights, step }, &mut Scratch::default(), &mut out).unwrap();
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
    method.vjp(Bound { q, weights, step }, &mut Scratch::default(), grad, &mut out).unwrap();
    out
}

pub fn ellipsoids() -> [&'static dyn Ellipsoid; 4] {
    [&Cholesky, &Eigen, &Extremum, &Diagonal]
}

/// The six that have a name in the registry, and CAL's.
pub fn projections() -> [&'static dyn Projection; 7] {
    [&Cholesky, &Eigen, &Extremum, &Diagonal, &ScalarisedMin, &IndependentMin, &MEAN_STD]
}

const MEAN_STD: MeanStd = MeanStd { cost: 1.0, reward: 1.0 };

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub fn times(matrix: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| dot(row, v)).collect()
}

pub fn transposed_times(matrix: &[Vec<f64>], v: &[f64]) -> Vec<f64> {
    (0..v.len()).map(|j| matrix.iter().zip(v).map(|(row, v)| row[j] * v).sum()).collect()
}

/// The textbook factor of a covariance, in the order given; a pivot below 1e-5 of its objective is
/// zero.
pub fn cholesky(covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = covariance.len();
    let mut low = vec![vec![0.0; n]; n];
    for j in 0..n {
        let square = covariance[j][j] - dot(&low[j][..j], &low[j][..j]);
        if square > 1e-10 * covariance[j][j] {
            low[j][j] = square.sqrt();
            for i in j + 1..n {
                low[i][j] = (covariance[i][j] - dot(&low[i][..j], &low[j][..j])) / low[j][j];
            }
        }
    }
    low
}

/// R of paper A.2-A.4 as a matrix, for a direction in which the clip fires.
pub fn rotation(low: &[Vec<f64>], u: &[f64]) -> Vec<Vec<f64>> {
    let n = u.len();
    let p = transposed_times(low, u);
    let a = dot(u, &p);
    let rho = dot(&p, &p).sqrt();
    let v: Vec<f64> = (0..n).map(|i| (p[i] - a * u[i]) / (rho * rho - a * a).sqrt()).collect();
    let k: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| v[i] * u[j] - u[i] * v[j]).collect()).collect();
    let cosine = (1.0 - (a / rho).powi(2)).sqrt();
    let square = |i: usize, j: usize| (0..n).map(|m| k[i][m] * k[m][j]).sum::<f64>();
    let entry = |i: usize, j: usize| {
        f64::from(u8::from(i == j)) - a / rho * k[i][j] + (1.0 - cosine) * square(i, j)
    };
    (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
}

pub fn assert_close(got: &[f64], wanted: &[f64], tolerance: f64) {
    assert_eq!(got.len(), wanted.len());
    for (i, (got, wanted)) in got.iter().zip(wanted).enumerate() {
        assert!(
            (got - wanted).abs() <= tolerance,
            "entry {i}: {got} instead of {wanted} (+-{tolerance:e})"
        );
    }
}

pub fn widen(values: &[f32]) -> Vec<f64> {
    values.iter().map(|&v| f64::from(v)).collect()
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, v| largest.max(v.abs()))
}
