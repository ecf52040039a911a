//! What holds for every ensemble of critics: the invariants of the bounds, one test each.

use crate::bounds;

use bounds::{
    Ensemble, assert_close, cholesky, dot, ellipsoids, ensembles, full_ensembles, largest, project,
    project_rows, projections, rotation, shaped, times, transposed_times, vjp_rows, widen,
};
use copq::projection::{
    Cholesky, Diagonal, Eigen, Ellipsoid, Extremum, IndependentMin, MeanStd, Projection, QView,
};
use proptest::prelude::*;

/// D' Sigma^-1 D, by forward substitution with the textbook factor.
fn squared_mahalanobis(covariance: &[Vec<f64>], offset: &[f64]) -> f64 {
    let low = cholesky(covariance);
    let mut z: Vec<f64> = Vec::new();
    for (row, &d) in low.iter().zip(offset) {
        let i = z.len();
        z.push((d - dot(&row[..i], &z)) / row[i]);
    }
    dot(&z, &z)
}

/// u . L u with the library's own L.
fn scalarised_margin(ensemble: &Ensemble) -> f64 {
    dot(&ensemble.unit(), &times(&ensemble.factor(&Cholesky), &ensemble.unit()))
}

/// Whether no pivot is small: the inverse of Sigma is then well conditioned.
fn is_well_conditioned(ensemble: &Ensemble) -> bool {
    let low = cholesky(&ensemble.covariance());
    ensemble.stds().iter().enumerate().all(|(j, std)| low[j][j] > 0.01 * std && *std > 0.0)
}

/// Away from the jump of Cholesky and Extremum where the scalarised value has no disagreement.
fn has_scalarised_disagreement(ensemble: &Ensemble) -> bool {
    scalarised_std(ensemble) > 1e-3 * ensemble.largest_std()
}

/// sqrt(u' Sigma u), from the deviations of u . Q: the quadratic form would lose half the digits of
/// a small one.
fn scalarised_std(ensemble: &Ensemble) -> f64 {
    let x = ensemble.deviations();
    let u = ensemble.unit();
    let scalarised =
        |k| dot(&u, &x.iter().skip(k).step_by(ensemble.critics).copied().collect::<Vec<_>>());
    let squares = (0..ensemble.critics).map(|k| scalarised(k).powi(2)).sum::<f64>();
    (squares / ensemble.critics as f64).sqrt()
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
            for (i, row) in c.iter().enumerate() {
                let product: Vec<f64> = c.iter().map(|other| dot(row, other)).collect();
                assert_close(&product, &covariance[i], 1e-10 * ensemble.largest_std().powi(2));
            }
        }
    }

    #[test]
    fn cholesky_is_lower_triangular_in_priority_order(ensemble in ensembles()) {
        for (i, row) in ensemble.factor(&Cholesky).iter().enumerate() {
            prop_assert!(row[i] >= 0.0);
            prop_assert!(row[i + 1..].iter().all(|&above| above == 0.0), "{row:?}");
        }
    }

    #[test]
    fn eigen_is_symmetric_and_positive(ensemble in ensembles()) {
        let c = ensemble.factor(&Eigen);
        let transposed: Vec<f64> = transposed_times(&c, &ensemble.unit());
        assert_close(&times(&c, &ensemble.unit()), &transposed, 1e-12 * ensemble.largest_std());
        prop_assert!(dot(&ensemble.unit(), &transposed) >= -1e-12 * ensemble.largest_std());
    }

    #[test]
    fn points_lie_on_the_unit_ellipsoid(ensemble in full_ensembles()) {
        prop_assume!(is_well_conditioned(&ensemble));
        for method in [&Cholesky as &dyn Ellipsoid, &Eigen, &Extremum] {
            let distance = squared_mahalanobis(&ensemble.covariance(), &ensemble.offset(method));
            prop_assert!((distance - 1.0).abs() < 1e-6, "{} at {distance}", method.name());
        }
    }

    #[test]
    fn a_lower_bound_never_scalarises_above_the_mean(ensemble in ensembles()) {
        for method in ellipsoids() {
            let margin = dot(&ensemble.unit(), &ensemble.offset(method));
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
        prop_assert!((dot(&u, &ensemble.offset(&Extremum)) - std).abs() <= slack);
        for method in [&Cholesky as &dyn Ellipsoid, &Eigen] {
            prop_assert!(dot(&u, &ensemble.offset(method)) <= std + slack);
        }
    }

    #[test]
    fn the_clip_leaves_the_positive_part(ensemble in ensembles()) {
        let margin = dot(&ensemble.unit(), &ensemble.offset(&Cholesky));
        let wanted = scalarised_margin(&ensemble).max(0.0);
        prop_assert!(
            (margin - wanted).abs() <= 1e-12 * ensemble.largest_std(),
            "{margin} instead of {wanted}"
        );
    }

    #[test]
    fn the_first_objective_answers_for_itself(ensemble in ensembles()) {
        prop_assume!(scalarised_margin(&ensemble) >= 0.0);
        let wanted = ensemble.stds()[0] * ensemble.unit()[0];
        prop_assert!(
            (ensemble.offset(&Cholesky)[0] - wanted).abs() <= 1e-12 * ensemble.largest_std()
        );
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
        let p = transposed_times(&low, &u);
        let a = dot(&u, &p);
        let rho = dot(&p, &p).sqrt();
        prop_assume!(a < 0.0 && a > -0.999 * rho && rho > 1e-3 * ensemble.largest_std());
        let wanted = times(&low, &times(&rotation(&low, &u), &u));
        assert_close(&ensemble.offset(&Cholesky), &wanted, 1e-9 * ensemble.largest_std());
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
        for method in ellipsoids() {
            let mut wanted = ensemble.offset(method);
            wanted[at] *= -1.0;
            assert_close(&flipped.offset(method), &wanted, 1e-9 * ensemble.largest_std());
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
            let scale = largest(&widen(&moved.q)).max(largest(&widen(&ensemble.q)));
            assert_close(&got, &wanted, 3.0 * f64::from(f32::EPSILON) * scale);
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
        for method in ellipsoids() {
            assert_close(
                &reversed.offset(method),
                &ensemble.offset(method),
                1e-9 * ensemble.largest_std(),
            );
        }
        for method in projections() {
            let got = reversed.bound(method, -1.0);
            let wanted = ensemble.bound(method, -1.0);
            assert_close(&widen(&got), &widen(&wanted), 1e-6 * largest(&widen(&ensemble.q)));
        }
    }

    #[test]
    fn the_order_of_the_objectives_matters_to_cholesky_only(ensemble in full_ensembles()) {
        prop_assume!(has_scalarised_disagreement(&ensemble));
        for method in [&Eigen as &dyn Ellipsoid, &Extremum, &Diagonal] {
            let mut back = reversed_objectives(&ensemble).offset(method);
            back.reverse();
            assert_close(&back, &ensemble.offset(method), 1e-9 * ensemble.largest_std());
        }
    }

    #[test]
    fn steps_are_lengths_along_one_offset(ensemble in ensembles(), step in -5.0..5.0_f32) {
        for method in ellipsoids() {
            let move_by = |(mean, offset): (f64, f64)| mean + f64::from(step) * offset;
            let wanted: Vec<f64> =
                ensemble.mean().into_iter().zip(ensemble.offset(method)).map(move_by).collect();
            let got =
                widen(&ensemble.bound(&copq::projection::by_name(method.name()).unwrap(), step));
            assert_close(&got, &wanted, 1e-7 * (largest(&wanted) + 10.0 * ensemble.largest_std()));
        }
    }

    #[test]
    fn a_step_of_zero_is_the_mean(ensemble in ensembles()) {
        let mean: Vec<f32> = ensemble.mean().into_iter().map(|m| m as f32).collect();
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
            let n = ensemble.objectives();
            let sums: Vec<f64> = (0..n).map(|i| gradient.iter().skip(i).step_by(n).sum()).collect();
            assert_close(&sums, &widen(&ensemble.grad), 1e-6 * (1.0 + largest(&gradient)));
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
    back.reverse();
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
