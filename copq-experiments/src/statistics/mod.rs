//! Statistics over seeds: means and intervals, comparisons, curves. A replicate is a seed, never an
//! episode. All statistics are NaN if there are no values or if one of them is NaN: a seed that
//! diverged is not left out silently. (Only [`min`] and [`max`] ignore NaNs.)
//!
//! ```
//! use copq_experiments::statistics::{Bootstrap, iqm, probability_of_improvement};
//!
//! let ours = [2_395.0, 2_751.0, 2_888.0, 2_540.0];
//! let theirs = [2_100.0, 2_800.0, 1_950.0, 2_300.0];
//! assert_eq!(iqm(&ours), 2_645.5);
//! assert_eq!(probability_of_improvement(&ours, &theirs), 13.0 / 16.0);
//!
//! // The same interval every time; under three seeds there is none.
//! let interval = Bootstrap::default().interval(&[&ours[..]], iqm);
//! assert!(interval.is_some_and(|[low, high]| low < 2_645.5 && 2_645.5 < high));
//! assert_eq!(Bootstrap::default().interval(&[&ours[..2]], iqm), None);
//! ```

mod bootstrap;
mod curve;
mod difference;

pub use bootstrap::{Bootstrap, FEWEST};
pub use curve::{area_under, steps_to};
pub use difference::Sample;

/// The arithmetic mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The standard deviation of the values themselves (divided by n), as papers report it.
pub fn std(values: &[f64]) -> f64 {
    let centre = mean(values);
    (values.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Whether one of the values is NaN.
fn has_nan(values: &[f64]) -> bool {
    values.iter().any(|value| value.is_nan())
}

/// The middle value, or the mean of the two middle ones.
pub fn median(values: &[f64]) -> f64 {
    if values.is_empty() || has_nan(values) {
        return f64::NAN;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[half] } else { 0.5 * (sorted[half - 1] + sorted[half]) }
}

/// The smallest value; NaNs are ignored.
pub fn min(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NAN, f64::min)
}

/// The largest value; NaNs are ignored.
pub fn max(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NAN, f64::max)
}

/// The interquartile mean: the mean of the middle half, with a quarter left out at either end
/// (rounded down, as SciPy's `trim_mean(values, 0.25)` does).
pub fn iqm(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if has_nan(values) {
        return f64::NAN;
    }
    let quarter = sorted.len() / 4;
    mean(&sorted[quarter..sorted.len() - quarter])
}

/// How likely a value of the first method is larger than one of the second; equal ones count half
/// (Mann and Whitney's U divided by the number of pairs).
pub fn probability_of_improvement(first: &[f64], second: &[f64]) -> f64 {
    if has_nan(first) || has_nan(second) {
        return f64::NAN;
    }
    let pairs = first.iter().flat_map(|x| second.iter().map(move |y| x.partial_cmp(y)));
    let wins: f64 = pairs
        .map(|order| match order {
            Some(std::cmp::Ordering::Greater) => 1.0,
            Some(std::cmp::Ordering::Equal) => 0.5,
            _ => 0.0,
        })
        .sum();
    wins / (first.len() * second.len()) as f64
}

/// A performance profile at one threshold: the share of the values above it (Agarwal et al. 2021).
pub fn profile(values: &[f64], threshold: f64) -> f64 {
    if has_nan(values) {
        return f64::NAN;
    }
    values.iter().filter(|value| **value > threshold).count() as f64 / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy's numbers (`tests/data/make_statistics.py`).
    pub(super) fn cases() -> Vec<serde_json::Value> {
        let mut reference: serde_json::Value =
            serde_json::from_str(include_str!("../../tests/data/statistics.json")).unwrap();
        let cases: Vec<_> = reference["cases"].as_array_mut().unwrap().drain(..).collect();
        assert!(cases.len() > 5);
        cases
    }

    pub(super) fn numbers(value: &serde_json::Value) -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    }

    #[test]
    fn scipys_numbers() {
        for case in cases() {
            let first = numbers(&case["first"]);
            let second = numbers(&case["second"]);
            let close = |got: f64, name: &str| {
                let wanted = case[name].as_f64().unwrap();
                assert!((got - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{name}: {got}");
            };
            close(mean(&first), "mean");
            close(std(&first), "std");
            close(iqm(&first), "iqm");
            close(probability_of_improvement(&first, &second), "improvement");
            close(area_under(&numbers(&case["steps"]), &first), "area");
        }
    }

    #[test]
    fn by_hand() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!((mean(&values), median(&values), median(&values[..3])), (2.5, 2.5, 3.0));
        assert_eq!((std(&values), min(&values), max(&values)), (1.25f64.sqrt(), 1.0, 4.0));
        assert!([mean, std, median, iqm, min, max].iter().all(|f| f(&[]).is_nan()));
        let diverged = [1.0, f64::NAN, 3.0, 2.0];
        assert!([mean, std, median, iqm].iter().all(|f| f(&diverged).is_nan()));
        assert_eq!((min(&diverged), max(&diverged)), (1.0, 3.0));
        for [a, b] in [[&values, &diverged], [&diverged, &values]] {
            assert!(probability_of_improvement(a, b).is_nan());
        }
        assert!(probability_of_improvement(&values, &[]).is_nan());
        let shares = [0.0, 1.0, 2.5, 4.0].map(|threshold| profile(&values, threshold));
        assert_eq!(shares, [1.0, 0.75, 0.5, 0.0]);
        assert!(profile(&diverged, 0.0).is_nan() && profile(&[], 0.0).is_nan());
    }
}
