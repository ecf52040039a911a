//! Every projection's gradient against central differences, away from the places that have none.

use crate::bounds;

use approx::assert_abs_diff_eq;
use bounds::{
    Ensemble, centred, ellipsoids, ensembles, full_ensembles, offset, projections, widen,
};
use copq::projection::{Ellipsoid, Projection};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

/// d(grad . offset)/dq in double precision, critics x objectives.
fn differences(method: &dyn Ellipsoid, ensemble: &Ensemble) -> DMatrix<f64> {
    let u = ensemble.unit();
    let grad = widen(&ensemble.grad);
    let steps = 1e-5 * ensemble.stds();
    let value = |at, by: f64| {
        let mut q = ensemble.values();
        q[at] += by;
        grad.dot(&offset(method, &centred(q), &u))
    };
    let slope = |at, step: f64| (value(at, step) - value(at, -step)) / (2.0 * step);
    DMatrix::from_fn(ensemble.critics, u.len(), |k, i| slope((k, i), steps[i]))
}

/// The same by the method's own gradient, centred.
fn formula(method: &dyn Ellipsoid, ensemble: &Ensemble) -> DMatrix<f64> {
    let x = ensemble.deviations();
    centred(bounds::offset_vjp(method, &x, &ensemble.unit(), &widen(&ensemble.grad)))
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
fn single_differences(method: &dyn Projection, ensemble: &Ensemble, step: f32) -> DVector<f64> {
    let value = |at: usize, by: f32| {
        let mut moved = ensemble.clone();
        moved.q[at] += by;
        widen(&ensemble.grad).dot(&widen(&moved.bound(method, step)))
    };
    let slope = |at, _| (value(at, STEP) - value(at, -STEP)) / (2.0 * f64::from(STEP));
    DVector::from_fn(ensemble.q.len(), slope)
}

/// Whether no two critics come so near to a tie that one step changes a choice.
fn has_clear_choices(ensemble: &Ensemble) -> bool {
    let values = ensemble.values();
    let objectives = values.column_iter().map(|column| column.into_owned());
    objectives.chain([&values * ensemble.unit()]).all(is_spread)
}

fn is_spread(mut values: DVector<f64>) -> bool {
    values.as_mut_slice().sort_by(f64::total_cmp);
    values.as_slice().windows(2).all(|pair| pair[1] - pair[0] > 2.0 * f64::from(STEP))
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
            let tolerance = 1e-5 * (1.0 + wanted.amax());
            assert_abs_diff_eq!(formula(method, &ensemble), wanted, epsilon = tolerance);
        }
    }

    #[test]
    fn gradients_through_the_public_call(
        ensemble in full_ensembles().prop_map(rescaled),
        step in prop_oneof![Just(-1.0), Just(4.66), -1.0..1.0_f32],
    ) {
        prop_assume!(ensemble.is_smooth() && has_clear_choices(&ensemble));
        for method in projections() {
            let wanted = single_differences(method, &ensemble, step);
            let got = widen(&ensemble.gradient(method, step));
            assert_abs_diff_eq!(got, wanted, epsilon = 0.03 * (1.0 + wanted.amax()));
        }
    }
}

#[test]
fn the_random_cases_include_fired_clips() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut fired = |_| {
        let ensemble = ensembles().new_tree(&mut runner).unwrap().current();
        ensemble.critics > 1 && ensemble.is_smooth() && ensemble.margin() < 0.0
    };
    assert!((0..1000).filter(|_| fired(())).count() > 20);
}
