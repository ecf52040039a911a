//! What a projection costs by itself: the bound and its gradient for a batch of 256 rows. For
//! comparison, faer's factors of the same rows, without bound or gradient.
//!
//! `cargo bench -p copq-bench --bench projection`; to run only some, add `-- 'project.*cholesky'`.

use std::fmt;

use copq::projection::{by_name, names};
use copq::{BoundQuery, QView, Rng, Scratch, Stream};
use divan::{Bencher, black_box};
use faer::Mat;

const ROWS: usize = 256;

fn main() {
    divan::main();
}

/// A projection and the shape of what it projects.
struct Case {
    name: &'static str,
    critics: usize,
    objectives: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} K={} N={}", self.name, self.critics, self.objectives)
    }
}

/// COP-Q's own shape first, then other numbers of critics, then other numbers of objectives with
/// one critic more.
fn cases() -> Vec<Case> {
    let shapes = [(4, 3), (2, 3), (10, 3), (32, 3), (2, 1), (11, 10), (26, 25), (51, 50)];
    let case =
        |(critics, objectives)| names().iter().map(move |name| Case { name, critics, objectives });
    shapes.into_iter().flat_map(case).collect()
}

/// The cases for faer, whose factors do not depend on the projection.
fn shapes() -> Vec<Case> {
    let shape = |n| Case { name: "faer", critics: n + 1, objectives: n };
    [3, 10, 25, 50].map(shape).into()
}

/// The critics' deviations from their mean, `critics x objectives`, for each of the rows.
fn deviations(case: &Case) -> Vec<Mat<f64>> {
    let q = normals(case.critics * ROWS * case.objectives);
    let mut rows = Vec::with_capacity(ROWS);
    for row in 0..ROWS {
        let at = |k, i| f64::from(q[(k * ROWS + row) * case.objectives + i]);
        let mean = |i| (0..case.critics).map(|k| at(k, i)).sum::<f64>() / case.critics as f64;
        rows.push(Mat::from_fn(case.critics, case.objectives, |k, i| at(k, i) - mean(i)));
    }
    rows
}

#[divan::bench(args = shapes())]
fn singular_values_and_vectors(bencher: Bencher<'_, '_>, case: &Case) {
    let rows = deviations(case);
    bencher.bench_local(|| {
        for x in &rows {
            black_box(x.thin_svd().unwrap());
        }
    });
}

#[divan::bench(args = shapes())]
fn qr(bencher: Bencher<'_, '_>, case: &Case) {
    let rows = deviations(case);
    bencher.bench_local(|| {
        for x in &rows {
            black_box(x.qr());
        }
    });
}

fn normals(len: usize) -> Vec<f32> {
    let mut values = vec![0.0; len];
    Rng::new(0, Stream::Batch).fill_normal(&mut values);
    values
}

#[divan::bench(args = cases())]
fn project(bencher: Bencher<'_, '_>, case: &Case) {
    let projection = by_name(case.name).unwrap();
    let q = normals(case.critics * ROWS * case.objectives);
    let weights = vec![1.0; case.objectives];
    let mut out = vec![0.0; ROWS * case.objectives];
    let q = QView::new(&q, case.critics, case.objectives).unwrap();
    let bound = BoundQuery { q, weights: &weights, step: -1.0 };
    let mut scratch = Scratch::default();
    bencher.bench_local(|| projection.project(bound, &mut scratch, &mut out).unwrap());
}

#[divan::bench(args = cases())]
fn vjp(bencher: Bencher<'_, '_>, case: &Case) {
    let projection = by_name(case.name).unwrap();
    let q = normals(case.critics * ROWS * case.objectives);
    let weights = vec![1.0; case.objectives];
    let grad = vec![1.0 / ROWS as f32; ROWS * case.objectives];
    let mut grad_q = vec![0.0; q.len()];
    let q = QView::new(&q, case.critics, case.objectives).unwrap();
    let bound = BoundQuery { q, weights: &weights, step: -1.0 };
    let mut scratch = Scratch::default();
    bencher.bench_local(|| projection.vjp(bound, &mut scratch, &grad, &mut grad_q).unwrap());
}
