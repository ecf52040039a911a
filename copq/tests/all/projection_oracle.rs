//! faer as a witness, for more objectives than the textbook's arithmetic is for.

use approx::assert_abs_diff_eq;
use copq::projection::{Cholesky, Eigen};
use faer::Mat;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::bounds::{Ensemble, offset, offset_vjp, shaped};

/// Up to 50 objectives, and more critics than objectives: 64 at most.
fn many() -> impl Strategy<Value = Ensemble> {
    (9..=50_usize, 1..=14_usize).prop_flat_map(|(n, spare)| shaped(n..=n, n + spare..=n + spare))
}

/// X / sqrt(K), `critics x objectives`.
fn scaled(ensemble: &Ensemble) -> Mat<f64> {
    let x = ensemble.deviations() / (ensemble.critics as f64).sqrt();
    Mat::from_fn(x.nrows(), x.ncols(), |k, i| x[(k, i)])
}

/// V S V'u
fn root_times(x: &Mat<f64>, u: &DVector<f64>) -> DVector<f64> {
    let svd = x.thin_svd().unwrap();
    let v = svd.V();
    let v = DMatrix::from_fn(v.nrows(), v.ncols(), |i, j| v[(i, j)]);
    let s = svd.S().column_vector();
    let s = DVector::from_fn(s.nrows(), |j, _| s[j]);
    &v * s.component_mul(&v.tr_mul(u))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn eigen_is_the_symmetric_root_of_the_covariance(ensemble in many()) {
        let wanted = root_times(&scaled(&ensemble), &ensemble.unit());
        let epsilon = 1e-9 * ensemble.largest_std();
        assert_abs_diff_eq!(ensemble.offset(&Eigen), wanted, epsilon = epsilon);
    }

    #[test]
    fn cholesky_is_the_triangle_of_a_qr(ensemble in many()) {
        let r = scaled(&ensemble).qr().thin_R().to_owned();
        let low = DMatrix::from_fn(r.ncols(), r.nrows(), |i, j| r[(j, i)] * r[(j, j)].signum());
        let wanted = low * ensemble.unit();
        prop_assume!(wanted.dot(&ensemble.unit()) > 0.0);
        let epsilon = 1e-9 * ensemble.largest_std();
        assert_abs_diff_eq!(ensemble.offset(&Cholesky), wanted, epsilon = epsilon);
    }

    #[test]
    fn gradients_are_slopes(ensemble in many(), toward in 0..1000_usize) {
        let x = ensemble.deviations();
        let u = ensemble.unit();
        let grad = DVector::from_fn(u.len(), |i, _| (1.0 + i as f64).sin());
        // One critic moves in one objective, and the others make room.
        let (row, objective) = (toward % x.nrows(), toward % u.len());
        let h = 1e-5 * ensemble.largest_std();
        let at = |h: f64| {
            let mut moved = x.clone();
            moved.column_mut(objective).add_scalar_mut(-h / x.nrows() as f64);
            moved[(row, objective)] += h;
            grad.dot(&offset(&Eigen, &moved, &u))
        };
        let slope = (at(h) - at(-h)) / (2.0 * h);
        let grad_x = offset_vjp(&Eigen, &x, &u, &grad);
        let got = grad_x[(row, objective)] - grad_x.column(objective).mean();
        assert_abs_diff_eq!(got, slope, epsilon = 1e-4 * (1.0 + slope.abs()));
    }
}

#[test]
fn fewer_critics_than_objectives_take_the_plain_way_to_the_same_root() {
    let q: Vec<f32> = (0..90).map(|i| ((i * 37) % 23) as f32 - 0.1 * i as f32).collect();
    let rows: Vec<&[f32]> = q.chunks_exact(10).collect();
    let ensemble = Ensemble::new(&rows, &[1.0; 10]);
    let wanted = root_times(&scaled(&ensemble), &ensemble.unit());
    let epsilon = 1e-9 * ensemble.largest_std();
    assert_abs_diff_eq!(ensemble.offset(&Eigen), wanted, epsilon = epsilon);
}
