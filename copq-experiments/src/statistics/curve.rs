//! Single numbers that summarise a learning curve.

use super::mean;

/// The mean height of a curve: the area under it, by trapezoids, divided by its length.
///
/// ```
/// use copq_experiments::statistics::area_under;
///
/// assert_eq!(area_under(&[0.0, 10.0, 20.0], &[0.0, 4.0, 4.0]), 3.0);
/// ```
pub fn area_under(steps: &[f64], values: &[f64]) -> f64 {
    let pairs = steps.windows(2).zip(values.windows(2));
    let area: f64 = pairs.map(|(s, v)| 0.5 * (v[0] + v[1]) * (s[1] - s[0])).sum();
    match (steps.first(), steps.last()) {
        (Some(first), Some(last)) if last > first => area / (last - first),
        _ => mean(values),
    }
}

/// The step at which the mean of `window` neighbouring evaluations first passes a threshold, if it
/// does: the step of the last of them.
///
/// ```
/// use copq_experiments::statistics::steps_to;
///
/// let steps = [0.0, 5.0, 10.0, 15.0];
/// let totals = [0.0, 900.0, 300.0, 900.0];
/// assert_eq!(steps_to(500.0, 1, &steps, &totals), Some(5.0));
/// assert_eq!(steps_to(500.0, 2, &steps, &totals), Some(10.0));
/// assert_eq!(steps_to(500.0, 3, &steps, &totals), Some(15.0));
/// assert_eq!(steps_to(800.0, 2, &steps, &totals), None);
/// ```
pub fn steps_to(threshold: f64, window: usize, steps: &[f64], values: &[f64]) -> Option<f64> {
    let means = values.windows(window.max(1)).map(mean);
    let passed = means.into_iter().position(|mean| mean > threshold)?;
    steps.get(passed + window.max(1) - 1).copied()
}
