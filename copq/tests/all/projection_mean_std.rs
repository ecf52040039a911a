//! CAL's bounds against their textbook formulas and central differences.

use crate::bounds;

use approx::assert_abs_diff_eq;
use bounds::{offset, offset_vjp, project, widen};
use copq::projection::MeanStd;
use nalgebra::{DMatrix, dmatrix, dvector};

/// Four critics of a cost and a reward; two reward networks, each shown twice.
const Q: [f32; 8] = [1.0, 5.0, 2.0, 3.0, 4.0, 5.0, 2.5, 3.0];

#[test]
fn the_cost_is_raised_by_its_unbiased_deviation_and_the_reward_is_the_smaller() {
    let costs = dvector![1.0f64, 2.0, 4.0, 2.5];
    let mean = costs.mean();
    let k = 0.5;
    let unbiased = (costs.add_scalar(-mean).norm_squared() / 3.0).sqrt();
    for lambda in [5.0, 0.01, 0.0] {
        let got = project(&MeanStd::cal(k, 4), &Q, 4, &[-lambda, 1.0], -1.0);
        assert_abs_diff_eq!(widen(&got), dvector![mean + k * unbiased, 3.0], epsilon = 1e-6);
    }
    // The optimist's side.
    let got = project(&MeanStd::cal(k, 4), &Q, 4, &[-1.0, 1.0], 1.0);
    assert_abs_diff_eq!(widen(&got), dvector![mean - k * unbiased, 5.0], epsilon = 1e-6);
}

#[test]
fn the_gradient_is_that_of_central_differences() {
    let method = MeanStd { cost: 0.7, reward: 1.3 };
    let u = dvector![-0.6, 0.8];
    let grad = dvector![1.5, -0.4];
    let x = dmatrix![-1.25, 0.75; -0.25, -1.0; 1.0, -0.5; 0.5, 0.75];
    let nudged = |at, by: f64| {
        let mut x = x.clone();
        x[at] += by;
        grad.dot(&offset(&method, &x, &u))
    };
    let slope = |k, i| (nudged((k, i), 1e-6) - nudged((k, i), -1e-6)) / 2e-6;
    let wanted = DMatrix::from_fn(4, 2, slope);
    assert_abs_diff_eq!(offset_vjp(&method, &x, &u, &grad), wanted, epsilon = 1e-8);
    let zeros = DMatrix::zeros(4, 2);
    assert_eq!(offset_vjp(&method, &zeros, &u, &grad), zeros);
}
