//! The critics' losses, one per objective, their gradient, and the checks that stop a diverged run.

use crate::{Error, QView, Result};

/// l_i = mean over critics and rows of (q_ki - y_i)^2, in f64.
pub(crate) fn squared_errors(q: QView<'_>, target: &[f32], losses: &mut [f64]) {
    let n = q.objectives();
    losses.fill(0.0);
    for critic in q.values().chunks_exact(target.len()) {
        for (q, y) in critic.chunks_exact(n).zip(target.chunks_exact(n)) {
            for ((loss, q), y) in losses.iter_mut().zip(q).zip(y) {
                let error = f64::from(q - y);
                *loss += error * error;
            }
        }
    }
    let count = (q.critics() * q.rows()) as f64;
    losses.iter_mut().for_each(|loss| *loss /= count);
}

/// The gradient of `sum_i weights_i l_i` in q.
pub(crate) fn squared_error_grad(q: QView<'_>, target: &[f32], weights: &[f64], grad: &mut [f32]) {
    let n = q.objectives();
    let scale = 2.0 / (q.critics() * q.rows()) as f64;
    for (critic, grad) in
        q.values().chunks_exact(target.len()).zip(grad.chunks_exact_mut(target.len()))
    {
        for (i, ((grad, q), y)) in grad.iter_mut().zip(critic).zip(target).enumerate() {
            *grad = (scale * weights[i % n]) as f32 * (q - y);
        }
    }
}

/// Means over critics and rows, and the critics' standard deviation (the root of the mean variance
/// over rows).
pub(crate) fn mean_and_std(q: QView<'_>, objective: usize) -> (f64, f64) {
    let mut total = 0.0;
    let mut variance = 0.0;
    let critics = q.critics() as f64;
    for row in 0..q.rows() {
        let value = |critic| f64::from(q.get(critic, row)[objective]);
        let mean = (0..q.critics()).map(value).sum::<f64>() / critics;
        variance += (0..q.critics()).map(|k| (value(k) - mean).powi(2)).sum::<f64>() / critics;
        total += mean;
    }
    (total / q.rows() as f64, (variance / q.rows() as f64).sqrt())
}

/// The correlation of two objectives' values over the critics: the mean covariance of all rows,
/// divided by the roots of the mean variances; 0 where critics agree.
pub(crate) fn correlation(q: QView<'_>, pair: [usize; 2]) -> f64 {
    let critics = q.critics() as f64;
    let [mut covariance, mut first, mut second] = [0.0; 3];
    for row in 0..q.rows() {
        let value = |critic: usize| pair.map(|i| f64::from(q.get(critic, row)[i]));
        let sum = (0..q.critics()).map(value).fold([0.0; 2], |[a, b], [x, y]| [a + x, b + y]);
        for [x, y] in (0..q.critics()).map(value) {
            let [x, y] = [x - sum[0] / critics, y - sum[1] / critics];
            covariance += x * y;
            first += x * x;
            second += y * y;
        }
    }
    let size = (first * second).sqrt();
    if size > 0.0 { covariance / size } else { 0.0 }
}

/// How far a bound (`rows x objectives`) lies below the critics' mean: `w . (mean - bound)`,
/// averaged over the rows.
pub(crate) fn margin(q: QView<'_>, bound: &[f32], weights: &[f64]) -> f64 {
    let total = |values: &[f32]| -> f64 {
        let rows = values.chunks_exact(weights.len());
        rows.map(|row| row.iter().zip(weights).map(|(&x, w)| f64::from(x) * w).sum::<f64>()).sum()
    };
    (total(q.values()) / q.critics() as f64 - total(bound)) / q.rows() as f64
}

/// An error that names the objective and the first rows if a `rows x objectives` array is not
/// finite.
pub(crate) fn check_finite(
    what: &str,
    values: &[f32],
    objectives: &[String],
    step: u64,
) -> Result<()> {
    let n = objectives.len();
    let Some(first) = values.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    let objective = first % n;
    let bad = values.chunks_exact(n).enumerate().filter(|(_, row)| !row[objective].is_finite());
    Err(Error::NonFinite {
        what: format!("{what} of objective '{}'", objectives[objective]),
        step,
        rows: bad.map(|(row, _)| row).take(8).collect(),
        hint: "check the environment's rewards and the critics' step size",
    })
}

/// An error if the policy gives a batch's actions a log-probability that is not finite.
pub(crate) fn check_finite_log_probs(log_probs: &[f32], step: u64) -> Result<()> {
    let bad = log_probs.iter().enumerate().filter(|(_, x)| !x.is_finite());
    let rows: Vec<usize> = bad.map(|(row, _)| row).take(8).collect();
    if rows.is_empty() {
        return Ok(());
    }
    Err(Error::NonFinite {
        what: "log-probability of the policy's actions".to_owned(),
        step,
        rows,
        hint: "the actor's weights have diverged; lower its step size",
    })
}

/// An error if an observation is not finite.
pub(crate) fn check_finite_obs(obs: &[f32], step: u64) -> Result<()> {
    check_finite_row("observation", obs, step, "the environment returned it; check its physics")
}

/// An error if any component of one row is not finite.
pub(crate) fn check_finite_row(
    what: &str,
    values: &[f32],
    step: u64,
    hint: &'static str,
) -> Result<()> {
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::NonFinite {
            what: format!("{what}, component {i}"),
            step,
            rows: vec![0],
            hint,
        }),
    }
}

/// An error if an action is not in the agents' range, [-1, 1].
pub(crate) fn check_unit(what: &str, action: &[f32]) -> Result<()> {
    match action.iter().find(|a| a.abs() > 1.0) {
        Some(a) => Err(Error::invalid(what, "numbers in [-1, 1]", a)),
        None => Ok(()),
    }
}

/// An error that names the objective whose loss is not finite.
pub(crate) fn check_finite_losses(losses: &[f64], objectives: &[String], step: u64) -> Result<()> {
    match losses.iter().position(|loss| !loss.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::NonFinite {
            what: format!("critic loss of objective '{}'", objectives[i]),
            step,
            rows: Vec::new(),
            hint: "the critics have diverged; lower their step size",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_rise_together_correlate() {
        // Three critics, one row: 1, 2, 3 against 2, 4, 6, then against 6, 4, 2, then against 1, 0,
        // 1.
        let of = |values: &[f32]| correlation(QView::new(values, 3, 2).unwrap(), [0, 1]);
        assert!((of(&[1.0, 2.0, 2.0, 4.0, 3.0, 6.0]) - 1.0).abs() < 1e-12);
        assert!((of(&[1.0, 6.0, 2.0, 4.0, 3.0, 2.0]) + 1.0).abs() < 1e-12);
        assert!(of(&[1.0, 1.0, 2.0, 0.0, 3.0, 1.0]).abs() < 1e-12);
        assert_eq!(of(&[1.0, 1.0, 2.0, 1.0, 3.0, 1.0]), 0.0);
    }

    /// Two critics, one row, weights 1 and 3: means 2 and 6, bounds 1 and 5.5.
    #[test]
    fn a_margin_is_weighted() {
        let values = [1.0, 5.0, 3.0, 7.0];
        let q = QView::new(&values, 2, 2).unwrap();
        assert_eq!(margin(q, &[1.0, 5.5], &[1.0, 3.0]), 1.0 + 3.0 * 0.5);
    }
}
