//! What holds for every ensemble of critics: the invariants of the bounds, one test each.

use crate::bounds;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use bounds::{
    Ensemble, ellipsoids, ensembles, full_ensembles, project, project_rows, projections, rotation,
    shaped, vjp_rows, widen,
};
use copq::projection::{
    Cholesky, Diagonal, Eigen, Ellipsoid, Extremum, IndependentMin, MeanStd, Projection, QView,
};
use nalgebra::DVector;
use proptest::prelude::*;

/// D' Sigma^-1 D.
fn squared_mahalanobis(ensemble: &Ensemble, offset: &DVector<f64>) -> f64 {
    let low = ensemble.covariance().cholesky().unwrap().l();
    low.solve_lower_triangular(offset).unwrap().norm_squared()
}

/// Whether no pivot is small: the inverse of Sigma is then well conditioned.
fn is_well_conditioned(ensemble: &Ensemble) -> bool {
    let Some(factor) = ensemble.covariance().cholesky() else { return false };
    factor.l().diagonal().iter().zip(&ensemble.stds()).all(|(pivot, std)| *pivot > 0.01 * std)
}

/// Away from the jump of Cholesky and Extremum where the scalarised value has no disagreement.
fn has_scalarised_disagreement(ensemble: &Ensemble) -> bool {
    scalarised_std(ensemble) > 1e-3 * ensemble.largest_std()
}

/// sqrt(u' Sigma u), from the deviations of u . Q: the quadratic form would lose half the digits of
/// a small one.
fn scalarised_std(ensemble: &Ensemble) -> f64 {
    (ensemble.deviations() * ensemble.unit()).norm() / (ensemble.critics as f64).sqrt()
}

/// The ensemble with its critics, and those of every row, in another order.
fn reversed_critics(ensemble: &Ensemble) -> Ensemble {
    let q = ensemble.q.chunks_exact(ensemble.objectives()).rev().flatten().copied().collect();
    Ensemble { q, ..ensemble.clone() }
}

fn reversed_objectives(ensemble: &Ensemble) -> Ensemble {
    let reverse = |values: &[f32]| values.iter().rev().copied().collect::<Vec<_>>();
    let q = ensemble.q.chunks_exact(ensemble.objectives()).flat_map(reverse).collect();
    Ensemble { q, weights: reverse(&ensemble.weights), ..ensemble.clone() }
}

fn map_objective(ensemble: &Ensemble, objective: usize, change: impl Fn(f32) -> f32) -> Ensemble {
    let mut changed = ensemble.clone();
    changed
        .q
        .iter_mut()
        .skip(objective)
        .step_by(ensemble.objectives())
        .for_each(|q| *q = change(*q));
    changed
}

proptest! {
    #![proptest_config(ProptestConfig {
        max_global_rejects: 100_000,
        ..ProptestConfig::with_cases(512)
    })]

    #[test]
    fn the_factor_is_a_square_root_of_the_covariance(ensemble in ensembles()) {
        let covariance = ensemble.covariance();
        for method in [&Cholesky as &dyn Ellipsoid, &Eigen] {
            let c = ensemble.factor(method);
            let tolerance = 1e-10 * ensemble.largest_std().powi(2);
            assert_abs_diff_eq!(&c * c.transpose(), covariance, epsilon = tolerance);
        }
    }

    #[test]
    fn cholesky_is_lower_triangular_in_priority_order(ensemble in ensembles()) {
        let low = ensemble.factor(&Cholesky);
        prop_assert!(low.diagonal().min() >= 0.0, "{low}");
        prop_assert_eq!(&low, &low.lower_triangle());
    }

    #[test]
    fn eigen_is_symmetric_and_positive(ensemble in ensembles()) {
        let c = ensemble.factor(&Eigen);
        let tolerance = 1e-12 * ensemble.largest_std();
        assert_abs_diff_eq!(c, c.transpose(), epsilon = tolerance);
        prop_assert!(c.symmetric_eigenvalues().min() >= -tolerance, "{c}");
    }

    #[test]
    fn points_lie_on_the_unit_ellipsoid(ensemble in full_ensembles()) {
        prop_assume!(is_well_conditioned(&ensemble));
        for method in [&Cholesky as &dyn Ellipsoid, &Eigen, &Extremum] {
            let distance = squared_mahalanobis(&ensemble, &ensemble.offset(method));
            let name = method.name();
            prop_assert!(abs_diff_eq!(distance, 1.0, epsilon = 1e-6), "{name} at {distance}");
        }
    }

    #[test]
    fn a_lower_bound_never_scalarises_above_the_mean(ensemble in ensembles()) {
        for method in ellipsoids() {
            let margin = ensemble.unit().dot(&ensemble.offset(method));
            prop_assert!(
                margin >= -1e-12 * ensemble.largest_std(),
                "{} at {margin}",
                method.name()
            );
        }
    }

    #[test]
    fn the_scalarised_margin_is_at_most_that_of_extremum(ensemble in ensembles()) {
        let u = ensemble.unit();
        let slack = 1e-11 * ensemble.largest_std();
        let std = scalarised_std(&ensemble);
        assert_abs_diff_eq!(u.dot(&ensemble.offset(&Extremum)), std, epsilon = slack);
        for method in [&Cholesky as &dyn Ellipsoid, &Eigen] {
            prop_assert!(u.dot(&ensemble.offset(method)) <= std + slack);
        }
    }

    #[test]
    fn the_clip_leaves_the_positive_part(ensemble in ensembles()) {
        let left = ensemble.unit().dot(&ensemble.offset(&Cholesky));
        let tolerance = 1e-12 * ensemble.largest_std();
        assert_abs_diff_eq!(left, ensemble.margin().max(0.0), epsilon = tolerance);
    }

    #[test]
    fn the_first_objective_answers_for_itself(ensemble in ensembles()) {
        prop_assume!(ensemble.margin() >= 0.0);
        let wanted = ensemble.stds()[0] * ensemble.unit()[0];
        let tolerance = 1e-12 * ensemble.largest_std();
        assert_abs_diff_eq!(ensemble.offset(&Cholesky)[0], wanted, epsilon = tolerance);
    }

    /// Paper eq. 10: a bound is conditioned on the objectives above its own alone, so that no other
    /// moves it, by a bit.
    #[test]
    fn lower_objectives_do_not_move_those_above(
        ensemble in shaped(2..=6, 1..=8),
        others in prop::collection::vec(-10.0..10.0_f32, 48),
        first in 1..6_usize,
    ) {
        let n = ensemble.objectives();
        let first = first.min(n - 1);
        let mut changed = ensemble.clone();
        for (row, others) in changed.q.chunks_exact_mut(n).zip(others.chunks_exact(n)) {
            row[first..].copy_from_slice(&others[first..]);
        }
        prop_assume!(ensemble.margin() >= 0.0 && changed.margin() >= 0.0);
        let above = |ensemble: &Ensemble| ensemble.bound(&Cholesky, -1.0)[..first].to_vec();
        prop_assert_eq!(above(&ensemble), above(&changed));
    }

    /// The advice of [`copq::Objective::cost`], with the clip and without.
    #[test]
    fn a_last_objective_of_weight_zero_changes_no_other(ensemble in shaped(1..=5, 1..=8)) {
        let n = ensemble.objectives();
        let row = |q: &[f32]| [q, &[q[0] * 3.0 - 1.0]].concat();
        let longer = Ensemble {
            q: ensemble.q.chunks_exact(n).flat_map(row).collect(),
            weights: [&ensemble.weights[..], &[0.0]].concat(),
            ..ensemble.clone()
        };
        let bound = longer.bound(&Cholesky, -1.0);
        prop_assert_eq!(&bound[..n], &ensemble.bound(&Cholesky, -1.0)[..]);
    }

    #[test]
    fn of_two_objectives_the_first_moves_as_its_weight_says(ensemble in shaped(2..=2, 3..=8)) {
        let first = ensemble.offset(&Cholesky)[0] * ensemble.unit()[0];
        prop_assert!(first >= -1e-12 * ensemble.largest_std());
    }

    #[test]
    fn the_closed_form_clip_is_the_rotation_of_the_appendix(ensemble in full_ensembles()) {
        let low = ensemble.factor(&Cholesky);
        let u = ensemble.unit();
        let p = low.tr_mul(&u);
        let a = u.dot(&p);
        let rho = p.norm();
        prop_assume!(a < 0.0 && a > -0.999 * rho && rho > 1e-3 * ensemble.largest_std());
        let wanted = &low * rotation(&low, &u) * u;
        let tolerance = 1e-9 * ensemble.largest_std();
        assert_abs_diff_eq!(ensemble.offset(&Cholesky), wanted, epsilon = tolerance);
    }

    #[test]
    fn a_flipped_objective_flips_its_own_offset_only(
        ensemble in full_ensembles(),
        at in 0..5_usize,
    ) {
        prop_assume!(has_scalarised_disagreement(&ensemble));
        let at = at % ensemble.objectives();
        let mut flipped = map_objective(&ensemble, at, |q| -q);
        flipped.weights[at] *= -1.0;
        let tolerance = 1e-9 * ensemble.largest_std();
        for method in ellipsoids() {
            let mut wanted = ensemble.offset(method);
            wanted[at] *= -1.0;
            assert_abs_diff_eq!(flipped.offset(method), wanted, epsilon = tolerance);
        }
    }

    #[test]
    fn moving_all_critics_moves_the_bound(
        ensemble in full_ensembles(),
        at in 0..5_usize,
        by in -4000..4000_i16,
    ) {
        prop_assume!(has_scalarised_disagreement(&ensemble));
        let by = f32::from(by) / 4.0;
        let at = at % ensemble.objectives();
        let moved = map_objective(&ensemble, at, |q| q + by);
        // The move itself is exact unless it pushes the values' last bits out.
        prop_assume!(moved.q.iter().zip(&ensemble.q).all(|(m, q)| m == q || m - by == *q));
        for method in projections() {
            let mut wanted = widen(&ensemble.bound(method, -1.0));
            wanted[at] += f64::from(by);
            let got = widen(&moved.bound(method, -1.0));
            let scale = widen(&moved.q).amax().max(widen(&ensemble.q).amax());
            let tolerance = 3.0 * f64::from(f32::EPSILON) * scale;
            assert_abs_diff_eq!(got, wanted, epsilon = tolerance);
        }
    }

    #[test]
    fn scaling_the_critics_scales_the_bound(ensemble in ensembles(), power in -60..60_i32) {
        let factor = 2.0_f32.powi(power);
        let mut scaled = ensemble.clone();
        scaled.q.iter_mut().for_each(|q| *q *= factor);
        for method in projections() {
            let wanted: Vec<f32> = ensemble.bound(method, 2.5).iter().map(|b| b * factor).collect();
            prop_assert_eq!(scaled.bound(method, 2.5), wanted, "{}", method.name());
            prop_assert_eq!(
                scaled.gradient(method, 2.5),
                ensemble.gradient(method, 2.5),
                "{}",
                method.name()
            );
        }
    }

    #[test]
    fn scaling_the_weights_changes_nothing(ensemble in ensembles(), power in -60..60_i32) {
        let mut scaled = ensemble.clone();
        scaled.weights.iter_mut().for_each(|w| *w *= 2.0_f32.powi(power));
        for method in projections() {
            prop_assert_eq!(
                scaled.bound(method, -1.0),
                ensemble.bound(method, -1.0),
                "{}",
                method.name()
            );
        }
    }

    #[test]
    fn the_order_of_the_critics_does_not_matter(ensemble in full_ensembles()) {
        prop_assume!(has_scalarised_disagreement(&ensemble));
        let reversed = reversed_critics(&ensemble);
        let tolerance = 1e-9 * ensemble.largest_std();
        for method in ellipsoids() {
            let wanted = ensemble.offset(method);
            assert_abs_diff_eq!(reversed.offset(method), wanted, epsilon = tolerance);
        }
        for method in projections() {
            let got = widen(&reversed.bound(method, -1.0));
            let wanted = widen(&ensemble.bound(method, -1.0));
            assert_abs_diff_eq!(got, wanted, epsilon = 1e-6 * widen(&ensemble.q).amax());
        }
    }

    #[test]
    fn the_order_of_the_objectives_matters_to_cholesky_only(ensemble in full_ensembles()) {
        prop_assume!(has_scalarised_disagreement(&ensemble));
        for method in [&Eigen as &dyn Ellipsoid, &Extremum, &Diagonal] {
            let mut back = reversed_objectives(&ensemble).offset(method);
            back.as_mut_slice().reverse();
            let tolerance = 1e-9 * ensemble.largest_std();
            assert_abs_diff_eq!(back, ensemble.offset(method), epsilon = tolerance);
        }
    }

    #[test]
    fn steps_are_lengths_along_one_offset(ensemble in ensembles(), step in -5.0..5.0_f32) {
        for method in ellipsoids() {
            let wanted = ensemble.mean() + f64::from(step) * ensemble.offset(method);
            let got =
                widen(&ensemble.bound(&copq::projection::by_name(method.name()).unwrap(), step));
            let tolerance = 1e-7 * (wanted.amax() + 10.0 * ensemble.largest_std());
            assert_abs_diff_eq!(got, wanted, epsilon = tolerance);
        }
    }

    #[test]
    fn a_step_of_zero_is_the_mean(ensemble in ensembles()) {
        let mean: Vec<f32> = ensemble.mean().iter().map(|&m| m as f32).collect();
        for method in projections() {
            prop_assert_eq!(&ensemble.bound(method, 0.0), &mean, "{}", method.name());
            let shares =
                ensemble.grad.iter().map(|&g| (f64::from(g) / ensemble.critics as f64) as f32);
            let wanted: Vec<f32> = (0..ensemble.critics).flat_map(|_| shares.clone()).collect();
            prop_assert_eq!(ensemble.gradient(method, 0.0), wanted, "{}", method.name());
        }
    }

    #[test]
    fn two_critics_of_one_objective_are_clipped_double_q(
        (a, b) in (finite(), finite()),
        weight in prop_oneof![0.001..1000.0_f32, -1000.0..-0.001_f32],
        grad in -10.0..10.0_f32,
    ) {
        prop_assume!(a != b);
        let low = if weight > 0.0 { a.min(b) } else { a.max(b) };
        let high = if weight > 0.0 { a.max(b) } else { a.min(b) };
        for method in projections() {
            let bound = |step| bounds::project(method, &[a, b], 2, &[weight], step);
            prop_assert_eq!(bound(-1.0), [low], "{}", method.name());
            prop_assert_eq!(bound(1.0), [high], "{}", method.name());
            let one_hot = |chosen: f32| {
                [if a == chosen { grad } else { 0.0 }, if b == chosen { grad } else { 0.0 }]
            };
            let vjp = |step| bounds::vjp(method, &[a, b], 2, &[weight], step, &[grad]);
            prop_assert_eq!(vjp(-1.0), one_hot(low), "{}", method.name());
            prop_assert_eq!(vjp(1.0), one_hot(high), "{}", method.name());
        }
    }

    #[test]
    fn weights_of_each_row_are_like_one_row_at_a_time(rows in rows()) {
        let critics = rows[0].critics;
        let n = rows[0].objectives();
        let critic = |k: usize| rows.iter().flat_map(move |row| row.q[k * n..(k + 1) * n].to_vec());
        let q: Vec<f32> = (0..critics).flat_map(critic).collect();
        let view = QView::new(&q, critics, n).unwrap();
        let weights: Vec<f32> = rows.iter().flat_map(|row| row.weights.clone()).collect();
        let grad: Vec<f32> = rows.iter().flat_map(|row| row.grad.clone()).collect();
        for method in projections() {
            let wanted: Vec<f32> = rows.iter().flat_map(|row| row.bound(method, -1.0)).collect();
            prop_assert_eq!(
                project_rows(method, view, &weights, -1.0),
                wanted,
                "{}",
                method.name()
            );
            let got = vjp_rows(method, view, &weights, -1.0, &grad);
            for (at, row) in rows.iter().enumerate() {
                let own: Vec<f32> =
                    (0..critics).flat_map(|k| got[view.range(k, at)].to_vec()).collect();
                prop_assert_eq!(own, row.gradient(method, -1.0), "{}", method.name());
            }
        }
    }

    #[test]
    fn one_set_of_weights_serves_all_rows(rows in rows()) {
        let critics = rows[0].critics;
        let n = rows[0].objectives();
        let q: Vec<f32> = (0..critics)
            .flat_map(|k| rows.iter().flat_map(move |row| row.q[k * n..(k + 1) * n].to_vec()))
            .collect();
        let view = QView::new(&q, critics, n).unwrap();
        let repeated = rows[0].weights.repeat(rows.len());
        let grad: Vec<f32> = rows.iter().flat_map(|row| row.grad.clone()).collect();
        for method in projections() {
            let once = project_rows(method, view, &rows[0].weights, -1.0);
            let each = project_rows(method, view, &repeated, -1.0);
            prop_assert_eq!(once, each, "{}", method.name());
            let once = vjp_rows(method, view, &rows[0].weights, -1.0, &grad);
            prop_assert_eq!(
                once,
                vjp_rows(method, view, &repeated, -1.0, &grad),
                "{}",
                method.name()
            );
        }
    }

    #[test]
    fn bounds_and_gradients_of_any_shape_are_finite(
        ensemble in shaped(1..=7, 1..=7),
        step in -5.0..5.0_f32,
    ) {
        for method in projections() {
            prop_assert!(
                ensemble.bound(method, step).iter().all(|b| b.is_finite()),
                "{}",
                method.name()
            );
            prop_assert!(
                ensemble.gradient(method, step).iter().all(|g| g.is_finite()),
                "{}",
                method.name()
            );
        }
    }

    #[test]
    fn one_critic_is_its_own_bound(ensemble in shaped(1..=5, 1..=1)) {
        for method in projections() {
            prop_assert_eq!(&ensemble.bound(method, -2.0), &ensemble.q, "{}", method.name());
            prop_assert_eq!(&ensemble.gradient(method, -2.0), &ensemble.grad, "{}", method.name());
        }
    }

    #[test]
    fn the_gradients_of_a_row_add_up_to_that_of_its_bound(ensemble in ensembles()) {
        for method in projections() {
            let gradient = widen(&ensemble.gradient(method, -1.0));
            let tolerance = 1e-6 * (1.0 + gradient.amax());
            let by_critic = gradient.as_slice().chunks_exact(ensemble.objectives());
            let sums: DVector<f64> = by_critic.map(DVector::from_column_slice).sum();
            assert_abs_diff_eq!(sums, widen(&ensemble.grad), epsilon = tolerance);
        }
    }
}

fn finite() -> impl Strategy<Value = f32> {
    use prop::num::f32::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    prop_oneof![-100.0..100.0_f32, NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE]
}

/// Rows of one batch.
fn rows() -> impl Strategy<Value = Vec<Ensemble>> {
    (1..=4_usize, 1..=6_usize)
        .prop_flat_map(|(n, k)| prop::collection::vec(shaped(n..=n, k..=k), 1..5))
}

#[test]
fn cholesky_depends_on_the_order_of_the_objectives() {
    let ensemble = Ensemble::new(&[&[10.0, 5.0], &[12.0, 4.0], &[11.0, 9.0]], &[1.0, 1.0]);
    let mut back = reversed_objectives(&ensemble).offset(&Cholesky);
    back.as_mut_slice().reverse();
    assert!((back[0] - ensemble.offset(&Cholesky)[0]).abs() > 0.1);
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let ensemble = Ensemble::new(&[&[10.1, 5.2], &[12.3, -4.7], &[11.9, 2.2]], &[0.3, 0.9]);
    for method in projections() {
        let once = (ensemble.bound(method, -1.0), ensemble.gradient(method, -1.0));
        assert!(
            (0..10)
                .all(|_| once == (ensemble.bound(method, -1.0), ensemble.gradient(method, -1.0)))
        );
    }
}

#[test]
fn names_and_ensemble_sizes() {
    let names: Vec<&str> = projections().map(Projection::name).to_vec();
    assert_eq!(names, *copq::projection::names());
    let all = copq::Ensemble::Spanning;
    let separate = copq::Ensemble::Separate { cost: 2, reward: 2 };
    assert_eq!(
        projections().map(Projection::ensemble),
        [all, all, all, all, copq::Ensemble::Joint(2), separate, all]
    );
}

/// A multiplier at rest gives a cost the weight -0: the larger of two cost critics still counts, as
/// it does for -1e-9.
#[test]
fn a_cost_without_weight_is_still_a_cost() {
    let q = [1.0, 5.0, 3.0, 9.0];
    for method in [&IndependentMin as &dyn Projection, &MeanStd { cost: 1.0, reward: 1.0 }] {
        let bound = |weight: f32, step| project(method, &q, 2, &[weight, 1.0], step);
        assert_eq!(
            (bound(-0.0, -1.0), bound(-0.0, 1.0)),
            (vec![3.0, 5.0], vec![1.0, 9.0]),
            "{}",
            method.name()
        );
        assert_eq!(bound(-1e-9, -1.0), bound(-0.0, -1.0), "{}", method.name());
        assert_eq!(bound(0.0, -1.0), [1.0, 5.0], "{}", method.name());
    }
}
