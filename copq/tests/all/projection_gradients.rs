//! Every projection's gradient against central differences, away from the places that have none.

use crate::bounds;

use bounds::{
    Ensemble, assert_close, centred, dot, ellipsoids, ensembles, full_ensembles, largest, offset,
    projections, widen,
};
use copq::projection::{Ellipsoid, Projection};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

/// d(grad . offset)/dq in double precision, critics x objectives.
fn differences(method: &dyn Ellipsoid, ensemble: &Ensemble) -> Vec<f64> {
    let u = ensemble.unit();
    let grad = widen(&ensemble.grad);
    let n = ensemble.objectives();
    let steps: Vec<f64> = ensemble.stds().iter().map(|std| 1e-5 * std).collect();
    let mut q = widen(&ensemble.q);
    let mut value = |at: usize, by: f64| {
        let held = q[at];
        q[at] += by;
        let value = dot(&grad, &offset(method, &centred(&q, n), ensemble.critics, &u));
        q[at] = held;
        value
    };
    let mut slope = |at, step: f64| (value(at, step) - value(at, -step)) / (2.0 * step);
    (0..ensemble.q.len()).map(|at| slope(at, steps[at % n])).collect()
}

/// The same by the method's own gradient, centred and critics x objectives.
fn formula(method: &dyn Ellipsoid, ensemble: &Ensemble) -> Vec<f64> {
    let x = ensemble.deviations();
    let grad = widen(&ensemble.grad);
    let n = ensemble.objectives();
    let grad_x = bounds::offset_vjp(method, &x, ensemble.critics, &ensemble.unit(), &grad);
    let transposed: Vec<f64> =
        (0..ensemble.q.len()).map(|at| grad_x[at % n * ensemble.critics + at / n]).collect();
    let centred = centred(&transposed, n);
    (0..ensemble.q.len()).map(|at| centred[at % n * ensemble.critics + at / n]).collect()
}

/// The step of differences in single precision, for objectives of a standard deviation near one.
const STEP: f32 = 1.0 / 512.0;

/// Every objective in units near its standard deviation; powers of two, so that no value is
/// rounded.
fn rescaled(mut ensemble: Ensemble) -> Ensemble {
    let n = ensemble.objectives();
    let units: Vec<f32> =
        ensemble.stds().iter().map(|std| 2.0_f32.powi(std.max(1e-6).log2() as i32)).collect();
    ensemble.q.iter_mut().enumerate().for_each(|(at, q)| *q /= units[at % n]);
    ensemble
}

/// d(grad . bound)/dq through the public, single-precision call.
fn single_differences(method: &dyn Projection, ensemble: &Ensemble, step: f32) -> Vec<f64> {
    let value = |at: usize, by: f32| {
        let mut moved = ensemble.clone();
        moved.q[at] += by;
        dot(&widen(&ensemble.grad), &widen(&moved.bound(method, step)))
    };
    let slope = |at| (value(at, STEP) - value(at, -STEP)) / (2.0 * f64::from(STEP));
    (0..ensemble.q.len()).map(slope).collect()
}

/// Whether no two critics come so near to a tie that one step changes a choice.
fn has_clear_choices(ensemble: &Ensemble) -> bool {
    let n = ensemble.objectives();
    let values = widen(&ensemble.q);
    let scores: Vec<f64> = values.chunks_exact(n).map(|q| dot(q, &ensemble.unit())).collect();
    let objective = |i| values.iter().skip(i).step_by(n).copied().collect::<Vec<_>>();
    (0..n).map(objective).chain([scores]).all(is_spread)
}

fn is_spread(mut values: Vec<f64>) -> bool {
    values.sort_by(f64::total_cmp);
    values.windows(2).all(|pair| pair[1] - pair[0] > 2.0 * f64::from(STEP))
}

proptest! {
    #![proptest_config(ProptestConfig {
        max_global_rejects: 1_000_000,
        ..ProptestConfig::with_cases(512)
    })]

    #[test]
    fn offsets_in_double_precision(ensemble in ensembles()) {
        prop_assume!(ensemble.critics > 1 && ensemble.is_smooth());
        for method in ellipsoids() {
            let wanted = differences(method, &ensemble);
            assert_close(&formula(method, &ensemble), &wanted, 1e-5 * (1.0 + largest(&wanted)));
        }
    }

    #[test]
    fn all_six_through_the_public_call(
        ensemble in full_ensembles().prop_map(rescaled),
        step in prop_oneof![Just(-1.0), Just(4.66), -1.0..1.0_f32],
    ) {
        prop_assume!(ensemble.is_smooth() && has_clear_choices(&ensemble));
        for method in projections() {
            let wanted = single_differences(method, &ensemble, step);
            assert_close(
                &widen(&ensemble.gradient(method, step)),
                &wanted,
                0.03 * (1.0 + largest(&wanted)),
            );
        }
    }
}

#[test]
fn the_random_cases_include_fired_clips() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut fired = |_| {
        let ensemble = ensembles().new_tree(&mut runner).unwrap().current();
        let low = bounds::cholesky(&ensemble.covariance());
        let a = dot(&ensemble.unit(), &bounds::times(&low, &ensemble.unit()));
        ensemble.critics > 1 && ensemble.is_smooth() && a < 0.0
    };
    assert!((0..1000).filter(|_| fired(())).count() > 20);
}
