//! Worked examples with their numbers: fixtures A to G of the algorithm notes, computed
//! independently in double precision.

use crate::bounds;
use approx::assert_abs_diff_eq;

use std::f64::consts::FRAC_1_SQRT_2;

use bounds::{Ensemble, widen};
use copq::projection::{Cholesky, Diagonal, Eigen, Extremum, Projection};
use nalgebra::{DVector, dmatrix, dvector};

fn low(ensemble: &Ensemble, method: &dyn Projection) -> DVector<f64> {
    widen(&ensemble.bound(method, -1.0))
}

/// The scalarised upper bound with the paper's beta.
fn ucb(ensemble: &Ensemble, method: &dyn Projection) -> f64 {
    ensemble.unit().dot(&widen(&ensemble.bound(method, 4.66)))
}

fn a() -> Ensemble {
    Ensemble::new(&[&[10.0, 5.0], &[12.0, 4.0], &[11.0, 9.0]], &[1.0, 1.0])
}

fn b() -> Ensemble {
    Ensemble::new(&[&[10.0, 5.0], &[12.0, -4.0], &[11.0, 2.0]], &[1.0, 1.0])
}

#[test]
fn a_all_four_methods() {
    let a = a();
    let wanted = dmatrix![0.816_496_580_9, 0.0; -0.408_248_290_5, 2.121_320_343_6];
    assert_abs_diff_eq!(a.factor(&Cholesky), wanted, epsilon = 1e-9);
    assert_abs_diff_eq!(a.margin(), 1.264_784_317_0, epsilon = 1e-9);
    for (method, wanted) in [
        (&Cholesky as &dyn Projection, dvector![10.422_649_730_8, 4.788_675_134_6]),
        (&Eigen, dvector![10.507_611_605_6, 4.554_010_026_9]),
        (&Extremum, dvector![10.845_696_650_0, 3.994_056_450_5]),
        (&Diagonal, dvector![10.422_649_730_8, 4.472_474_768_3]),
    ] {
        assert_abs_diff_eq!(low(&a, method), wanted, epsilon = 1e-6);
    }
    assert_abs_diff_eq!(ucb(&a, &Cholesky), 17.914_710_197_4, epsilon = 2e-6);
    assert_abs_diff_eq!(ucb(&a, &Extremum), 19.139_082_859_7, epsilon = 2e-6);
}

#[test]
fn b_the_clip_fires() {
    let b = b();
    let wanted = dmatrix![0.816_496_580_9, 0.0; -3.674_234_614_2, FRAC_1_SQRT_2];
    assert_abs_diff_eq!(b.factor(&Cholesky), wanted, epsilon = 1e-9);
    assert_abs_diff_eq!(b.margin(), -1.075_315_626_0, epsilon = 1e-9);
    let turned = dvector![0.240_192_230_7, 0.970_725_343_4];
    assert_abs_diff_eq!(b.offset(&Cholesky), b.factor(&Cholesky) * turned, epsilon = 1e-9);
    let wanted = dvector![10.803_883_864_9, 1.196_116_135_1];
    assert_abs_diff_eq!(low(&b, &Cholesky), wanted, epsilon = 1e-6);
    assert_abs_diff_eq!(ucb(&b, &Cholesky), 8.485_281_374_2, epsilon = 2e-6);
}

#[test]
fn c_a_cost_comes_first() {
    let c = Ensemble::new(&[&[3.0, 7.0], &[5.0, 11.0], &[4.0, 6.0]], &[-2.0, 1.0]);
    assert_abs_diff_eq!(c.margin(), 0.282_842_712_5, epsilon = 1e-9);
    // The cost is raised, and the reward too: the two rise together.
    let wanted = dvector![4.730_296_743_3, 8.828_137_954_6];
    assert_abs_diff_eq!(low(&c, &Cholesky), wanted, epsilon = 1e-6);
}

#[test]
fn d_unequal_weights() {
    let critics: [&[f32]; 4] =
        [&[100.0, 50.0, -10.0], &[104.0, 46.0, -12.0], &[98.0, 53.0, -9.0], &[101.0, 60.0, -14.0]];
    let d = Ensemble::new(&critics, &[1.0, 5.0, 1.0]);
    assert_abs_diff_eq!(d.margin(), 3.652_417_599_0, epsilon = 1e-9);
    let wanted = dvector![100.333_333_333_3, 48.204_894_887_7, -9.586_326_327_6];
    assert_abs_diff_eq!(low(&d, &Cholesky), wanted, epsilon = 1e-5);
    assert_abs_diff_eq!(ucb(&d, &Cholesky), 84.522_134_984_0, epsilon = 2e-5);
}

#[test]
fn e_the_clip_fires_among_three() {
    let critics: [&[f32]; 4] =
        [&[1.0, 0.0, 0.0], &[3.0, -6.0, 2.0], &[2.0, 1.0, -5.0], &[0.0, 4.0, 1.0]];
    let e = Ensemble::new(&critics, &[1.0, 1.0, 1.0]);
    assert_abs_diff_eq!(e.margin(), -0.754_040_500_4, epsilon = 1e-9);
    let turned = dvector![0.172_583_485_3, 0.479_817_403_7, 0.860_226_830_4];
    assert_abs_diff_eq!(e.offset(&Cholesky), e.factor(&Cholesky) * turned, epsilon = 1e-9);
    let wanted = dvector![1.307_045_797_5, -0.475_194_676_1, -0.081_851_121_5];
    assert_abs_diff_eq!(low(&e, &Cholesky), wanted, epsilon = 1e-6);
}

#[test]
fn f_one_objective() {
    let f = Ensemble::new(&[&[2.0], &[5.0]], &[1.0]);
    assert_eq!(f.bound(&Cholesky, -1.0), [2.0]);
    assert_abs_diff_eq!(ucb(&f, &Cholesky), 10.49, epsilon = 1e-6);
}

#[test]
fn g_a_fired_clip_can_raise_the_first_objective() {
    let critics: [&[f32]; 4] =
        [&[4.0, -7.0, -9.0], &[-7.0, 8.0, -5.0], &[-6.0, 1.0, 6.0], &[-8.0, 4.0, 5.0]];
    let g = Ensemble::new(&critics, &[1.0, 1.0, 1.0]);
    assert_abs_diff_eq!(g.margin(), -2.186_937_104_5, epsilon = 1e-9);
    let wanted = dvector![-0.504_755_721_7, 1.471_515_957_8, -0.966_760_236];
    assert_abs_diff_eq!(g.offset(&Cholesky), wanted, epsilon = 1e-9);
}

#[test]
fn the_clip_rate_counts_the_rows_that_fire() {
    use copq::projection::{BoundQuery, QView, Scratch, by_name};
    // Rows A, B, A, A, critic by critic.
    let a = a().q;
    let b = b().q;
    let critic = |k: usize| [&a, &b, &a, &a].map(|row| row[2 * k..2 * k + 2].to_vec()).concat();
    let q = [critic(0), critic(1), critic(2)].concat();
    let bound = BoundQuery { q: QView::new(&q, 3, 2).unwrap(), weights: &[1.0, 1.0], step: -1.0 };
    let mut scratch = Scratch::default();
    let mut out = [0.0; 8];
    assert_eq!(scratch.clip_rate(), 0.0);
    for &name in copq::projection::names() {
        Cholesky.project(bound, &mut scratch, &mut out).unwrap();
        Cholesky.vjp(bound, &mut scratch, &[1.0; 8], &mut [0.0; 24]).unwrap();
        assert_eq!(scratch.clip_rate(), 0.25);
        by_name(name).unwrap().project(bound, &mut scratch, &mut out).unwrap();
        assert_eq!(scratch.clip_rate(), if name == "cholesky" { 0.25 } else { 0.0 });
    }
}
