//! faer as a witness, for more objectives than the textbook's arithmetic is for.

use copq::projection::{Cholesky, Eigen};
use faer::Mat;
use proptest::prelude::*;

use crate::bounds::{Ensemble, dot, offset, offset_vjp, shaped};

/// Up to 50 objectives, and more critics than objectives: 64 at most.
fn many() -> impl Strategy<Value = Ensemble> {
    (9..=50_usize, 1..=14_usize).prop_flat_map(|(n, spare)| shaped(n..=n, n + spare..=n + spare))
}

/// X / sqrt(K), `critics x objectives`.
fn scaled(ensemble: &Ensemble) -> Mat<f64> {
    let x = ensemble.deviations();
    let k = ensemble.critics;
    Mat::from_fn(k, ensemble.objectives(), |row, i| x[i * k + row] / (k as f64).sqrt())
}

/// A matrix times a vector.
fn times(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let column = Mat::from_fn(vector.len(), 1, |i, _| vector[i]);
    let product = matrix * column;
    (0..product.nrows()).map(|i| product[(i, 0)]).collect()
}

fn assert_near(got: &[f64], wanted: &[f64], size: f64) {
    for (i, (got, wanted)) in got.iter().zip(wanted).enumerate() {
        assert!((got - wanted).abs() <= 1e-9 * size, "objective {i}: {got} instead of {wanted}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn eigen_is_the_symmetric_root_of_the_covariance(ensemble in many()) {
        let svd = scaled(&ensemble).thin_svd().unwrap();
        let s = svd.S().column_vector();
        let root = svd.V() * Mat::from_fn(s.nrows(), s.nrows(), |i, j| {
            if i == j { s[i] } else { 0.0 }
        }) * svd.V().transpose();
        let wanted = times(&root, &ensemble.unit());
        assert_near(&ensemble.offset(&Eigen), &wanted, ensemble.largest_std());
    }

    #[test]
    fn cholesky_is_the_triangle_of_a_qr(ensemble in many()) {
        let r = scaled(&ensemble).qr().thin_R().to_owned();
        let low = Mat::from_fn(r.ncols(), r.nrows(), |i, j| r[(j, i)] * r[(j, j)].signum());
        let offset = times(&low, &ensemble.unit());
        prop_assume!(dot(&offset, &ensemble.unit()) > 0.0);
        assert_near(&ensemble.offset(&Cholesky), &offset, ensemble.largest_std());
    }

    #[test]
    fn gradients_are_slopes(ensemble in many(), toward in 0..1000_usize) {
        let k = ensemble.critics;
        let x = ensemble.deviations();
        let u = ensemble.unit();
        let grad: Vec<f64> = (0..u.len()).map(|i| (1.0 + i as f64).sin()).collect();
        // One critic moves in one objective, and the others make room.
        let (i, row) = (toward % u.len(), toward % k);
        let h = 1e-5 * ensemble.largest_std();
        let at = |h: f64| {
            let mut moved = x.clone();
            for (critic, x) in moved[i * k..(i + 1) * k].iter_mut().enumerate() {
                *x += h * (f64::from(u8::from(critic == row)) - 1.0 / k as f64);
            }
            dot(&grad, &offset(&Eigen, &moved, k, &u))
        };
        let slope = (at(h) - at(-h)) / (2.0 * h);
        let mut grad_x = offset_vjp(&Eigen, &x, k, &u, &grad);
        let mean = grad_x[i * k..(i + 1) * k].iter().sum::<f64>() / k as f64;
        let got = grad_x.swap_remove(i * k + row) - mean;
        prop_assert!((got - slope).abs() < 1e-4 * (1.0 + slope.abs()), "{got} instead of {slope}");
    }
}

#[test]
fn as_many_critics_as_objectives_take_the_plain_way_to_the_same_root() {
    let q: Vec<f32> = (0..90).map(|i| ((i * 37) % 23) as f32 - 0.1 * i as f32).collect();
    let rows: Vec<&[f32]> = q.chunks_exact(10).collect();
    let ensemble = Ensemble::new(&rows, &[1.0; 10]);
    let svd = scaled(&ensemble).thin_svd().unwrap();
    let s = svd.S().column_vector();
    let root = svd.V() * Mat::from_fn(s.nrows(), 10, |i, j| s[i] * svd.V()[(j, i)]);
    let wanted = times(&root, &ensemble.unit());
    assert_near(&ensemble.offset(&Eigen), &wanted, ensemble.largest_std());
}
