//! Ensembles at the edge: agreement, collinearity, certainty, extreme scales, and inputs that are
//! no ensemble at all.

use std::sync::Arc;

use crate::bounds;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use bounds::{Ensemble, ellipsoids, projections};
use copq::projection::{
    BoundQuery, Cholesky, Deviations, Eigen, Ellipsoid, IndependentMin, Projection, QView,
    ScalarisedMin, Scratch, Work, by_name,
};
use copq::{Error, Result};
use nalgebra::{DMatrix, dvector};
use proptest::prelude::*;

proptest! {
    #[test]
    fn identical_critics_are_exactly_their_mean(
        value in prop::collection::vec(prop::num::f32::NORMAL, 1..6),
        critics in 1..12_usize,
        step in -5.0..5.0_f32,
    ) {
        let q = value.repeat(critics);
        let weights = vec![0.7; value.len()];
        for method in projections() {
            let bound = bounds::project(method, &q, critics, &weights, step);
            prop_assert_eq!(&bound, &value, "{}", method.name());
        }
    }

    #[test]
    fn identical_critics_share_the_gradient(
        value in prop::collection::vec(-1e9..1e9_f32, 1..6),
        critics in 1..12_usize,
    ) {
        let q = value.repeat(critics);
        let weights = vec![-0.7; value.len()];
        for method in ellipsoids() {
            let method = by_name(method.name()).unwrap();
            let gradient =
                bounds::vjp(&method, &q, critics, &weights, -1.0, &vec![3.0; value.len()]);
            let share = (3.0 / critics as f64) as f32;
            prop_assert!(gradient.iter().all(|&g| g == share), "{}: {gradient:?}", method.name());
        }
    }
}

#[test]
fn collinear_objectives_move_as_one() {
    // The second objective is -3 times the first; of its own it has no disagreement.
    let ensemble = Ensemble::new(&[&[1.0, -3.0], &[2.0, -6.0], &[7.0, -21.0]], &[2.0, -1.0]);
    let low = ensemble.factor(&Cholesky);
    assert_eq!(low[(1, 1)], 0.0);
    assert_abs_diff_eq!(low[(1, 0)], -3.0 * low[(0, 0)], epsilon = 1e-12 * low[(0, 0)]);
    for method in ellipsoids() {
        let offset = ensemble.offset(method);
        let ratio = if method.name() == "diagonal" { -1.5 } else { -3.0 };
        assert!(
            abs_diff_eq!(offset[1], ratio * offset[0], epsilon = 1e-9 * offset[0].abs()),
            "{}: {offset:?}",
            method.name()
        );
    }
}

#[test]
fn collinear_objectives_keep_the_gradient_of_what_they_share() {
    // Moving both objectives along their common line changes L_11 and L_21 only, which is smooth: d
    // ln D = d ln scale.
    let ensemble = Ensemble::new(&[&[1.0, 3.0], &[2.0, 6.0], &[7.0, 21.0]], &[2.0, 1.0]);
    let x = ensemble.deviations();
    for method in ellipsoids() {
        let offset = ensemble.offset(method);
        let gradient = bounds::offset_vjp(method, &x, &ensemble.unit(), &dvector![1.0, 0.5]);
        let along = gradient.dot(&x);
        let value = offset[0] + 0.5 * offset[1];
        assert!(
            abs_diff_eq!(along, value, epsilon = 1e-9 * value),
            "{}: {along} instead of {value}",
            method.name()
        );
    }
}

#[test]
fn what_is_only_rounding_passes_no_gradient_on() {
    for ratio in (3..30).map(|ratio| ratio as f32) {
        let ensemble =
            Ensemble::new(&[&[1.0, ratio], &[2.0, 2.0 * ratio], &[7.0, 7.0 * ratio]], &[2.0, 1.0]);
        let x = ensemble.deviations();
        // A centred direction across the first objective's deviations, in the space of critics.
        let across = dvector![x[1] - x[2], x[2] - x[0], x[0] - x[1]];
        let slope = |method, first: f64, second: f64| {
            let gradient = bounds::offset_vjp(method, &x, &ensemble.unit(), &dvector![1.0, 0.5]);
            gradient.tr_mul(&across).dot(&dvector![first, second])
        };
        // Moves that make a zero pivot, or a zero eigenvalue, positive on both sides: a kink, whose
        // middle is zero.
        let ratio = f64::from(ratio);
        assert_abs_diff_eq!(slope(&Cholesky, 0.0, 1.0), 0.0, epsilon = 1e-9);
        assert_abs_diff_eq!(slope(&Eigen, ratio, -1.0), 0.0, epsilon = 1e-9 * ratio);
    }
}

#[test]
fn a_certain_objective_is_left_alone() {
    for (certain, critics) in
        [(0, [[5.0_f32, 1.0], [5.0, 2.0], [5.0, 4.0]]), (1, [[1.0, 5.0], [2.0, 5.0], [4.0, 5.0]])]
    {
        let ensemble = Ensemble::new(&[&critics[0], &critics[1], &critics[2]], &[1.0, 1.0]);
        for method in projections() {
            assert_eq!(ensemble.bound(method, -1.0)[certain], 5.0, "{}", method.name());
            assert_eq!(ensemble.bound(method, 3.0)[certain], 5.0, "{}", method.name());
        }
    }
}

#[test]
fn a_certain_first_objective_leaves_a_smaller_cholesky() {
    let both = Ensemble::new(
        &[&[5.0, 1.0, 2.0], &[5.0, 2.0, -4.0], &[5.0, 4.0, 1.0], &[5.0, 3.0, 9.0]],
        &[1.0, 2.0, 1.0],
    );
    let rest = Ensemble::new(&[&[1.0, 2.0], &[2.0, -4.0], &[4.0, 1.0], &[3.0, 9.0]], &[2.0, 1.0]);
    // The direction keeps the length that the certain objective takes of it.
    let share = (5.0_f64 / 6.0).sqrt();
    let got = both.offset(&Cholesky).remove_row(0);
    assert_abs_diff_eq!(got, share * rest.offset(&Cholesky), epsilon = 1e-12);
    let gradient = both.gradient(&Cholesky, -1.0);
    assert!(gradient.iter().step_by(3).all(|&g| g == 0.25), "the mean's share only: {gradient:?}");
}

/// Cholesky's documented jump: however little the critics disagree about the first objective, the
/// direction decides how the second is bounded.
#[test]
fn beside_a_zero_pivot_the_direction_decides() {
    let second = |first: [f32; 3]| {
        let [a, b, c] = first;
        Ensemble::new(&[&[a, 1.0], &[b, -1.0], &[c, 0.0]], &[2.0, 1.0]).offset(&Cholesky)[1]
    };
    let std = (2.0_f64 / 3.0).sqrt();
    let [u, v] = [2.0, 1.0].map(|w: f64| w / 5.0_f64.sqrt());
    for small in [1e-3, 1e-12, 1e-30] {
        assert_abs_diff_eq!(second([small, -small, 0.0]), std * u, epsilon = 1e-12);
        assert_abs_diff_eq!(
            second([small, small, -2.0 * small]),
            std * v,
            epsilon = 1e-2 * f64::from(small)
        );
    }
    assert_abs_diff_eq!(second([0.0; 3]), std * v, epsilon = 1e-12);
}

#[test]
fn scalarised_agreement_is_no_disagreement() {
    // Sigma u = 0 with Sigma not zero: the documented jump. Offset and gradient stay finite.
    let ensemble = Ensemble::new(&[&[1.0, -1.0], &[-1.0, 1.0], &[0.5, -0.5]], &[1.0, 1.0]);
    for method in ellipsoids() {
        let offset = ensemble.offset(method);
        let std = ensemble.largest_std();
        assert!(offset.amax() <= std, "{}: {offset:?}", method.name());
        let gradient = ensemble.gradient(&by_name(method.name()).unwrap(), -1.0);
        assert!(gradient.iter().all(|g| g.abs() < 10.0), "{}: {gradient:?}", method.name());
    }
    assert_eq!(ensemble.offset(&copq::projection::Extremum), dvector![0.0, 0.0]);
}

#[test]
fn the_clip_does_not_fire_on_rounding() {
    // Sigma u is zero but for rounding, whatever its sign: the offset is L u.
    for weight in (3..40).map(|weight| weight as f32) {
        let ensemble = Ensemble::new(
            &[&[1.0, -weight], &[-2.0, 2.0 * weight], &[0.5, -0.5 * weight]],
            &[weight, 1.0],
        );
        let wanted = ensemble.stds()[0] * ensemble.unit()[0];
        assert_abs_diff_eq!(ensemble.offset(&Cholesky)[0], wanted, epsilon = 1e-9 * wanted);
    }
}

#[test]
fn a_clip_next_to_parallel_turns_all_the_way() {
    // p is almost -u: across p there is a millionth of u, of which no digit may be lost.
    let steep = 2.0_f32.powi(21);
    let weight = 2.0_f32.powi(-20);
    let ensemble =
        Ensemble::new(&[&[0.0, 0.5], &[1.0, -steep], &[2.0, -2.0 * steep]], &[1.0, weight]);
    let low = ensemble.factor(&Cholesky);
    let u = ensemble.unit();
    let p = low.tr_mul(&u);
    assert!(p[0] < -0.5 && p[1] > 0.0 && p[1] < 1e-6, "{p:?}");
    // Two objectives: R u = (p_2, -p_1) / rho.
    let wanted = low * dvector![p[1], -p[0]].normalize();
    let offset = ensemble.offset(&Cholesky);
    assert_abs_diff_eq!(offset[0], wanted[0], epsilon = 1e-9 * wanted[0].abs());
    assert_abs_diff_eq!(offset[1], wanted[1], epsilon = 1e-9 * wanted[1].abs());
}

#[test]
fn tiny_and_huge_values_keep_their_relative_accuracy() {
    let plain = [[3.0_f32, -1.0], [5.0, 2.0], [4.0, -7.0]];
    for (first, second) in
        [(1e-12, 1e-12), (1e12, 1e12), (1e-12, 1e12), (1e12, 1e-12), (1e-15, 1e15)]
    {
        let critics = plain.map(|q| [q[0] * first, q[1] * second]);
        let ensemble = Ensemble::new(&[&critics[0], &critics[1], &critics[2]], &[1.0, 1.0]);
        for method in projections() {
            let bound = ensemble.bound(method, -1.0);
            assert!(
                bound.iter().all(|b| b.is_finite() && *b != 0.0),
                "{}: {bound:?}",
                method.name()
            );
            assert!(
                ensemble.gradient(method, -1.0).iter().all(|g| g.is_finite()),
                "{}",
                method.name()
            );
        }
        // Cholesky treats every objective in its own units: the offset is that of the plain values,
        // rescaled.
        let low = ensemble.factor(&Cholesky);
        let wanted =
            Ensemble::new(&[&plain[0], &plain[1], &plain[2]], &[1.0, 1.0]).factor(&Cholesky);
        let units = dvector![f64::from(first), f64::from(second)];
        let rescaled = DMatrix::from_diagonal(&units.map(f64::recip)) * low;
        assert_abs_diff_eq!(rescaled, wanted, epsilon = 1e-6);
    }
}

#[test]
fn a_large_mean_does_not_drown_a_small_spread() {
    let spread = [[0.0_f32, 0.25], [0.5, 0.0], [0.25, -0.5]];
    let ensemble = |shift: f32| {
        let critics = spread.map(|q| q.map(|q| q + shift));
        Ensemble::new(&[&critics[0], &critics[1], &critics[2]], &[1.0, 2.0])
    };
    for method in ellipsoids() {
        // 2^21 leaves two binary places to an f32.
        let near = ensemble(0.0);
        let far = ensemble(2_097_152.0);
        assert_abs_diff_eq!(far.offset(method), near.offset(method), epsilon = 1e-12);
    }
}

#[test]
fn more_objectives_than_critics() {
    let ensemble =
        Ensemble::new(&[&[1.0, 2.0, 3.0, 4.0], &[2.0, 4.0, 1.0, 0.0]], &[1.0, 1.0, 1.0, 1.0]);
    let low = ensemble.factor(&Cholesky);
    assert!(
        low.columns(1, 3).iter().all(|&l| l == 0.0),
        "one difference spans one dimension: {low:?}"
    );
    // The root of v v'.
    let v = dvector![0.5, 1.0, -1.0, -2.0];
    assert_abs_diff_eq!(ensemble.factor(&Eigen), &v * v.transpose() / v.norm(), epsilon = 1e-12);
}

#[test]
fn as_many_pivots_as_critics_less_one() {
    // Three critics span two dimensions, however badly conditioned the first two objectives are.
    let near = 1.0 + 2.0_f32.powi(-22);
    for shift in (1..50).map(|shift| 0.37 * shift as f32) {
        let critics = [[0.3, 0.3, shift], [shift, near * shift, -0.4], [-1.1, -1.1, 0.2]];
        let low = Ensemble::new(&[&critics[0], &critics[1], &critics[2]], &[1.0, 1.0, 1.0])
            .factor(&Cholesky);
        assert!(low[(0, 0)] > 0.0 && low[(1, 1)] > 0.0 && low[(2, 2)] == 0.0, "{low:?}");
    }
}

#[test]
fn fifty_objectives_on_the_verge_of_dependence() {
    // Fifty noisy copies of one line: pivots of 1e-3, and a bound that is still on the right side.
    let noise = |k: usize, i: usize| 1e-3 * ((k * 37 + i * 101 + k * i * 13) % 97) as f32;
    let q: Vec<Vec<f32>> =
        (0..51).map(|k| (0..50).map(|i| k as f32 * 0.1 + noise(k, i)).collect()).collect();
    let rows: Vec<&[f32]> = q.iter().map(Vec::as_slice).collect();
    let ensemble = Ensemble::new(&rows, &[1.0; 50]);
    for method in ellipsoids() {
        let margin = ensemble.unit().dot(&ensemble.offset(method));
        assert!(margin > 0.0, "{}", method.name());
        assert!(
            ensemble.gradient(&by_name(method.name()).unwrap(), -1.0).iter().all(|g| g.is_finite())
        );
    }
}

#[test]
fn ties_go_to_the_first_critic() {
    let q = [1.0, 4.0, 1.0, 4.0, 3.0, 9.0];
    for method in [&ScalarisedMin as &dyn Projection, &IndependentMin] {
        assert_eq!(
            bounds::vjp(method, &q, 3, &[1.0, 1.0], -1.0, &[1.0, 2.0]),
            [1.0, 2.0, 0.0, 0.0, 0.0, 0.0]
        );
    }
}

#[test]
fn the_baselines_choose_as_documented() {
    let q = [1.0, 9.0, 2.0, 3.0];
    let bound = |method: &dyn Projection, weights: &[f32], step| {
        bounds::project(method, &q, 2, weights, step)
    };
    assert_eq!(bound(&ScalarisedMin, &[1.0, 1.0], -1.0), [2.0, 3.0]);
    assert_eq!(bound(&ScalarisedMin, &[1.0, 1.0], 1.0), [1.0, 9.0]);
    assert_eq!(bound(&IndependentMin, &[1.0, 1.0], -1.0), [1.0, 3.0]);
    assert_eq!(bound(&IndependentMin, &[1.0, 1.0], 1.0), [2.0, 9.0]);
    // A cost is pessimistic where it is high.
    assert_eq!(bound(&IndependentMin, &[-1.0, 1.0], -1.0), [2.0, 3.0]);
    assert_eq!(bound(&IndependentMin, &[-1.0, 1.0], 1.0), [1.0, 9.0]);
    assert_eq!(bound(&IndependentMin, &[1.0, 1.0], -0.5), [1.25, 4.5]);
    assert_eq!(
        bounds::vjp(&IndependentMin, &q, 2, &[1.0, 1.0], -0.5, &[1.0, 1.0]),
        [0.75, 0.25, 0.25, 0.75]
    );
}

#[test]
fn a_nan_comes_through() {
    for method in projections() {
        let bound =
            bounds::project(method, &[1.0, 2.0, f32::NAN, 4.0, 5.0, 7.0], 3, &[1.0, 1.0], -1.0);
        assert!(bound[0].is_nan(), "{}", method.name());
    }
}

/// What every method says to these, forward and backward alike but for the name of a wrong length.
fn refusal(weights: &[f32], step: f32, out: usize, grad: usize) -> String {
    let q = QView::new(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], 2, 2).unwrap();
    let texts = projections().map(|method| {
        let bound = BoundQuery { q, weights, step };
        let mut scratch = Scratch::default();
        let projected = method.project(bound, &mut scratch, &mut vec![0.0; out]);
        let backward = method.vjp(bound, &mut scratch, &vec![0.0; out], &mut vec![0.0; grad]);
        let backward = backward.unwrap_err().to_string();
        assert_eq!(
            projected.is_err(),
            grad == 8,
            "{}: only the gradient's length is none of its business",
            method.name()
        );
        if let Err(forward) = projected {
            assert_eq!(
                backward.replace("gradient of the bound", "bound"),
                forward.to_string(),
                "{}",
                method.name()
            );
        }
        backward
    });
    assert!(texts.iter().all(|text| *text == texts[0]), "{texts:?}");
    texts[0].clone()
}

#[test]
fn unusable_inputs_are_named() {
    let weights = "scalarisation weight";
    for (given, wanted) in [
        (
            refusal(&[1.0], -1.0, 4, 8),
            format!(
                "{weights}s: wanted 2 values (one per objective) or 4 (one set for each of 2 \
                 rows), got 1"
            ),
        ),
        (
            refusal(&[0.0, -0.0], -1.0, 4, 8),
            format!("{weights}s in set 0: wanted at least one that is not zero, got only zeros"),
        ),
        (
            refusal(&[1.0, 1.0, 0.0, 0.0], -1.0, 4, 8),
            format!("{weights}s in set 1: wanted at least one that is not zero, got only zeros"),
        ),
        (
            refusal(&[1.0, f32::NAN], -1.0, 4, 8),
            format!(
                "{weight} of objective 1 in set 0: wanted a finite number, got NaN",
                weight = weights
            ),
        ),
        (
            refusal(&[1.0, 1.0, f32::INFINITY, 1.0], -1.0, 4, 8),
            format!("{weights} of objective 0 in set 1: wanted a finite number, got inf"),
        ),
        (
            refusal(&[1.0, 1.0], f32::NAN, 4, 8),
            "step of the bound: wanted a finite number, got NaN".to_owned(),
        ),
        (
            refusal(&[1.0, 1.0], -1.0, 4, 7),
            "gradient of the critic values: wanted 8 values, got 7".to_owned(),
        ),
        (
            refusal(&[1.0, 1.0], -1.0, 3, 8),
            "gradient of the bound: wanted 4 values, got 3".to_owned(),
        ),
    ] {
        assert_eq!(given, wanted);
    }
}

#[test]
fn an_error_leaves_the_output_alone() {
    let q = QView::new(&[1.0, 2.0, 3.0, 4.0], 2, 1).unwrap();
    let mut out = [7.0; 2];
    let bound = BoundQuery { q, weights: &[1.0, f32::NAN], step: -1.0 };
    assert!(Cholesky.project(bound, &mut Scratch::default(), &mut out).is_err());
    assert_eq!(out, [7.0; 2]);
}

/// An ellipsoid written outside the crate: the first critic's deviation. Its gradient is not
/// centred.
#[derive(Debug)]
struct TowardsFirst;

impl Ellipsoid for TowardsFirst {
    fn name(&self) -> &'static str {
        "towards-first"
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], work: &mut Work, out: &mut [f64]) {
        out.iter_mut().zip(x.iter().zip(u)).for_each(|(out, (x, u))| *out = x[0] * u);
        work.report_clip();
    }

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        _: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        for (i, grad_x) in grad_x.chunks_exact_mut(x.critics()).enumerate() {
            grad_x[0] += grad[i] * u[i];
        }
    }
}

#[test]
fn a_foreign_ellipsoid_is_centred_and_counted() {
    // With u = 1 and step 1 the bound is the first critic itself: the mean's share of the others
    // cancels.
    let q = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let mut scratch = Scratch::default();
    let mut out = [0.0; 2];
    let bound = BoundQuery { q: QView::new(&q, 3, 1).unwrap(), weights: &[2.0], step: 1.0 };
    TowardsFirst.project(bound, &mut scratch, &mut out).unwrap();
    assert_eq!((out, scratch.clip_rate()), ([1.0, 2.0], 1.0));
    let gradient = bounds::vjp(&TowardsFirst, &q, 3, &[2.0], 1.0, &[1.0, 3.0]);
    assert_abs_diff_eq!(gradient[..], [1.0, 3.0, 0.0, 0.0, 0.0, 0.0][..], epsilon = 1e-7);
}

/// A projection written outside the crate, without an ellipsoid.
#[derive(Debug)]
struct FirstCritic;

impl Projection for FirstCritic {
    fn name(&self) -> &'static str {
        "first-critic"
    }

    fn project(&self, bound: BoundQuery<'_>, scratch: &mut Scratch, out: &mut [f32]) -> Result<()> {
        out.copy_from_slice(&bound.q.values()[..out.len()]);
        scratch.report_clips(1, bound.q.rows());
        Ok(())
    }

    fn vjp(
        &self,
        _: BoundQuery<'_>,
        _: &mut Scratch,
        grad: &[f32],
        grad_q: &mut [f32],
    ) -> Result<()> {
        grad_q.fill(0.0);
        grad_q[..grad.len()].copy_from_slice(grad);
        Ok(())
    }
}

#[test]
fn a_foreign_projection_is_like_the_built_in() {
    let boxed: Arc<dyn Projection> = Arc::new(FirstCritic);
    let q = [1.0, 2.0, 3.0, 4.0];
    let mut scratch = Scratch::default();
    let mut out = [0.0; 2];
    let bound = BoundQuery { q: QView::new(&q, 2, 1).unwrap(), weights: &[1.0], step: -1.0 };
    boxed.project(bound, &mut scratch, &mut out).unwrap();
    assert_eq!((out, scratch.clip_rate()), ([1.0, 2.0], 0.5));
    assert_eq!((boxed.name(), boxed.ensemble()), ("first-critic", copq::Ensemble::Spanning));
    let taken_by_value = |projection: Arc<dyn Projection>| {
        bounds::vjp(&projection, &q, 2, &[1.0], -1.0, &[1.0, 1.0])
    };
    assert_eq!(taken_by_value(boxed), [1.0, 1.0, 0.0, 0.0]);
}

#[test]
fn an_unknown_name_lists_the_known_nearest_first() {
    let error = by_name("diagnal").unwrap_err();
    assert!(matches!(error, Error::Unknown { kind: "projection", .. }));
    let text = error.to_string();
    assert!(text.starts_with("unknown projection 'diagnal'; known: diagonal, "), "{text}");
    assert!(copq::projection::names().iter().all(|name| text.contains(name)), "{text}");
}

#[test]
fn values_far_apart_are_widened_exactly() {
    // The f64 mean of these two cannot hold both; their minimum must come out all the same.
    assert_eq!(bounds::project(&Cholesky, &[1e-30, 1e10], 2, &[1.0], -1.0), [1e-30]);
}
