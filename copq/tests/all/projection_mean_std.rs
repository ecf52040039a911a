//! CAL's bounds against their textbook formulas and central differences.

use crate::bounds;

use bounds::{assert_close, offset, offset_vjp, project, widen};
use copq::projection::MeanStd;

/// Four critics of a cost and a reward; two reward networks, each shown twice.
const Q: [f32; 8] = [1.0, 5.0, 2.0, 3.0, 4.0, 5.0, 2.5, 3.0];

#[test]
fn the_cost_is_raised_by_its_unbiased_deviation_and_the_reward_is_the_smaller() {
    let mean = 9.5 / 4.0;
    let k = 0.5;
    let unbiased =
        ([1.0f64, 2.0, 4.0, 2.5].iter().map(|q| (q - mean).powi(2)).sum::<f64>() / 3.0).sqrt();
    for lambda in [5.0, 0.01, 0.0] {
        let got = project(&MeanStd::cal(k, 4), &Q, 4, &[-lambda, 1.0], -1.0);
        assert_close(&widen(&got), &[mean + k * unbiased, 3.0], 1e-6);
    }
    // The optimist's side.
    let got = project(&MeanStd::cal(k, 4), &Q, 4, &[-1.0, 1.0], 1.0);
    assert_close(&widen(&got), &[mean - k * unbiased, 5.0], 1e-6);
}

#[test]
fn the_gradient_is_that_of_central_differences() {
    let method = MeanStd { cost: 0.7, reward: 1.3 };
    let u = [-0.6, 0.8];
    let grad = [1.5, -0.4];
    let x = [-1.25, -0.25, 1.0, 0.5, 0.75, -1.0, -0.5, 0.75];
    let value =
        |x: &[f64]| offset(&method, x, 4, &u).iter().zip(&grad).map(|(o, g)| o * g).sum::<f64>();
    let wanted: Vec<f64> = (0..x.len())
        .map(|i| {
            let nudged = |by: f64| {
                let mut copy = x;
                copy[i] += by;
                value(&copy)
            };
            (nudged(1e-6) - nudged(-1e-6)) / 2e-6
        })
        .collect();
    assert_close(&offset_vjp(&method, &x, 4, &u, &grad), &wanted, 1e-8);
    assert_eq!(offset_vjp(&method, &[0.0; 8], 4, &u, &grad), [0.0; 8]);
}
