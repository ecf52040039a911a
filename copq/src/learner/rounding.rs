//! What fewer bits do to the critics' values, beside how far the critics are apart.

use super::Learner;
use crate::{Net, Observer, QView, Result};

/// Updates between two looks.
const EVERY: u64 = 1_000;

/// From here on bounds are blurred: critics agree to some 2e-3 of their values.
const LARGE: f64 = 0.25;

impl Learner {
    /// Every now and then: logs `q_rounding`, and warns once if bounds are blurred.
    pub(super) fn look_at_rounding(&mut self, log: &mut dyn Observer) -> Result<()> {
        if !self.updates.is_multiple_of(EVERY) {
            return Ok(());
        }
        let batch = &self.batch;
        let mut exact = vec![0.0; self.buffers.q.len()];
        if !self.critic.exact_values(&batch.obs, &batch.action, &mut exact)? {
            return Ok(());
        }
        let q = &mut self.buffers.q;
        self.critic.values(Net::Online, &batch.obs, &batch.action, q)?;
        let exact = QView::new(&exact, self.critic.critics(), self.objectives.len())?;
        let rounding = rounding(q, exact);
        log.scalar(self.steps, "q_rounding", rounding);
        if rounding > LARGE && !self.has_warned_of_rounding {
            self.has_warned_of_rounding = true;
            let text = format!(
                "16 bits blur the critics' values by {rounding:.2} of their standard deviation, and bounds \
                 with them: go on with networks.precision = \"backward\" or \"f32\""
            );
            log.warn(self.steps, &text);
        }
        Ok(())
    }
}

/// The root mean square of what values differ from exact ones by, in critics' standard deviations.
fn rounding(q: &[f32], exact: QView<'_>) -> f64 {
    let critics = exact.critics();
    let share = exact.values().len() / critics;
    let of = |values: &[f32], k: usize, at: usize| f64::from(values[k * share + at]);
    let mut differences = 0.0;
    let mut spread = 0.0;
    for at in 0..share {
        let mean = (0..critics).map(|k| of(exact.values(), k, at)).sum::<f64>() / critics as f64;
        for k in 0..critics {
            let value = of(exact.values(), k, at);
            differences += (of(q, k, at) - value).powi(2);
            spread += (value - mean).powi(2);
        }
    }
    (differences / spread).sqrt()
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn rounding_is_in_standard_deviations() {
        // Two critics one apart from their mean, at two rows; values off by 0.1 and 0.
        let exact = [1.0, 5.0, 3.0, 7.0];
        let q = [1.1, 5.0, 3.0, 6.9];
        let view = QView::new(&exact, 2, 1).unwrap();
        assert_abs_diff_eq!(rounding(&q, view), (0.02f64 / 4.0).sqrt(), epsilon = 1e-6);
        assert_eq!(rounding(&exact, view), 0.0);
    }
}
