//! The ellipsoid methods against 80-digit values (`data/projection_vectors.py`,
//! `data/projection_gradients.py`).

use crate::bounds;

use approx::{abs_diff_eq, assert_abs_diff_eq};
use bounds::widen;
use copq::projection::{BoundQuery, Projection, QView, Scratch, by_name};
use nalgebra::DVector;
use serde_json::Value;

const METHODS: [&str; 4] = ["cholesky", "eigen", "extremum", "diagonal"];

fn cases() -> Vec<Value> {
    let text = include_str!("../data/projection_vectors.json");
    serde_json::from_str::<Value>(text).unwrap()["cases"].as_array().unwrap().clone()
}

fn gradients() -> Value {
    serde_json::from_str(include_str!("../data/projection_gradients.json")).unwrap()
}

/// A vector, or a matrix row after row.
fn numbers(value: &Value) -> DVector<f64> {
    fn flat(value: &Value) -> Vec<f64> {
        match value {
            Value::Array(values) => values.iter().flat_map(flat).collect(),
            number => vec![number.as_f64().unwrap()],
        }
    }
    DVector::from_vec(flat(value))
}

fn singles(value: &Value) -> Vec<f32> {
    numbers(value).iter().map(|&v| v as f32).collect()
}

fn objectives(case: &Value) -> usize {
    case["n"].as_u64().unwrap() as usize
}

fn critics(case: &Value) -> usize {
    case["e"].as_u64().unwrap() as usize
}

fn largest_std(case: &Value) -> f64 {
    numbers(&case["cov"]).amax().sqrt()
}

/// The bound and the clip rate.
fn bound(method: &dyn Projection, case: &Value, step: f32) -> (DVector<f64>, f64) {
    let q = singles(&case["q"]);
    let weights = singles(&case["u_raw"]);
    let view = QView::new(&q, critics(case), objectives(case)).unwrap();
    let mut scratch = Scratch::default();
    let mut out = vec![f32::NAN; objectives(case)];
    method
        .project(BoundQuery { q: view, weights: &weights, step }, &mut scratch, &mut out)
        .unwrap();
    (widen(&out), scratch.clip_rate())
}

fn check_bound(method: &dyn Projection, case: &Value, step: f32, side: &str) {
    let expected = &case["expect"][method.name()];
    let (got, clip_rate) = bound(method, case, step);
    let wanted = numbers(&expected[side]);
    assert_eq!(got.len(), wanted.len());
    for (&got, &wanted) in got.iter().zip(&wanted) {
        // A millionth of the largest standard deviation, and two roundings of the value itself.
        let tolerance = 1e-6 * largest_std(case) + f64::from(f32::EPSILON) * wanted.abs();
        let name = &case["name"];
        let method = method.name();
        assert!(
            abs_diff_eq!(got, wanted, epsilon = tolerance),
            "{name} {method} {side}: {got} instead of {wanted}"
        );
    }
    assert_eq!(
        clip_rate > 0.0,
        expected["clipped"].as_bool().unwrap(),
        "{} {}",
        case["name"],
        method.name()
    );
}

#[test]
fn lower_and_upper_bounds() {
    let cases = cases();
    assert_eq!(cases.len(), 99);
    for (case, method) in
        cases.iter().flat_map(|case| METHODS.map(|method| (case, by_name(method).unwrap())))
    {
        check_bound(&method, case, -1.0, "lower");
        check_bound(&method, case, case["beta"].as_f64().unwrap() as f32, "upper");
    }
}

fn check_gradient(method: &str, case: &Value, wanted: &Value) {
    let q = singles(&case["q"]);
    let weights = singles(&case["u_raw"]);
    let grad = singles(&case["w"]);
    let got = bounds::vjp(&by_name(method).unwrap(), &q, critics(case), &weights, -1.0, &grad);
    let wanted = numbers(wanted);
    println!("{} {method}", case["name"]);
    assert_abs_diff_eq!(widen(&got), wanted, epsilon = 1e-4 * wanted.amax());
}

#[test]
fn gradients_of_lower_bounds() {
    let mut checked = 0;
    let more = gradients();
    for (case, method) in cases().iter().flat_map(|case| METHODS.map(|method| (case, method))) {
        let own = case["expect"][method].get("grad_w_lower");
        let added =
            more.get(case["name"].as_str().unwrap()).and_then(|methods| methods.get(method));
        if let Some(wanted) = own.or(added) {
            check_gradient(method, case, wanted);
            checked += 1;
        }
    }
    // Every case and method but one jump and two methods of the largest case.
    assert_eq!(checked, 4 * 99 - 3);
}
