//! How much fewer bits change the critics' values, compared with how far apart the critics are.

use super::Learner;
use crate::{Net, Observer, QView, Result};

/// Updates between two measurements.
const EVERY: u64 = 1_000;

/// Above this, bounds are blurred: the critics agree to within about 2e-3 of their values.
const LARGE: f64 = 0.25;

impl Learner {
    /// Every `EVERY` updates: logs `q_rounding`, and warns once if bounds are blurred.
    pub(super) fn look_at_rounding(&mut self, log: &mut dyn Observer) -> Result<()> {
        if !self.updates.is_multiple_of(EVERY) {
            return Ok(());
        }
        let batch = &self.batch;
        // This is rare, so it may allocate.
        let mut exact = vec![0.0; self.buffers.q.len()];
        if !self.critic.exact_values(&batch.obs, &batch.action, &mut exact)? {
            return Ok(());
        }
        let q = &mut self.buffers.q;
        self.critic.values(Net::Online, &batch.obs, &batch.action, q)?;
        let exact = QView::new(&exact, self.critic.critics(), self.objectives.len())?;
        let Some((rounding, objective)) = most_blurred(&rounding(q, exact), &self.objectives)
        else {
            return Ok(());
        };
        log.scalar(self.steps, "q_rounding", rounding);
        if rounding > LARGE && !self.has_warned_of_rounding {
            self.has_warned_of_rounding = true;
            let text = format!(
                "16 bits blur the critics' values of {objective} by {rounding:.2} of their \
                 standard deviation, and so its bound: continue with networks.precision = \
                 \"backward\" or \"f32\" in the run's config.toml"
            );
            log.warn(self.steps, &text);
        }
        Ok(())
    }
}

/// The largest of these, and the objective it belongs to.
fn most_blurred<'a>(roundings: &[Option<f64>], names: &'a [String]) -> Option<(f64, &'a String)> {
    let named = roundings.iter().zip(names);
    let blurred = named.filter_map(|(rounding, name)| Some(((*rounding)?, name)));
    blurred.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The root mean square difference between each objective's values and the exact ones, in units of
/// the critics' standard deviation; `None` where the critics agree.
fn rounding(q: &[f32], exact: QView<'_>) -> Vec<Option<f64>> {
    let critics = exact.critics();
    let n = exact.objectives();
    let share = exact.values().len() / critics;
    let of = |values: &[f32], k: usize, at: usize| f64::from(values[k * share + at]);
    let of_objective = |objective: usize| {
        let mut differences = 0.0;
        let mut spread = 0.0;
        for at in (objective..share).step_by(n) {
            let mean =
                (0..critics).map(|k| of(exact.values(), k, at)).sum::<f64>() / critics as f64;
            for k in 0..critics {
                let value = of(exact.values(), k, at);
                differences += (of(q, k, at) - value).powi(2);
                spread += (value - mean).powi(2);
            }
        }
        (spread > 0.0).then(|| (differences / spread).sqrt())
    };
    (0..n).map(of_objective).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_in_each_objectives_standard_deviations() {
        // Two critics, two rows: one apart from their mean about the first objective, a tenth about
        // the second, not at all about the third.
        let exact = [1.0, 0.1, 5.0, 5.0, 0.1, 5.0, 3.0, 0.3, 5.0, 7.0, 0.3, 5.0];
        let mut q = exact;
        let view = QView::new(&exact, 2, 3).unwrap();
        assert_eq!(rounding(&q, view), [Some(0.0), Some(0.0), None]);
        q[0] += 0.1;
        q[9] -= 0.1;
        q[4] += 0.1;
        let wanted = [(0.02f64 / 4.0).sqrt(), (0.01f64 / 0.04).sqrt()];
        let names = ["cost", "speed", "effort"].map(str::to_owned);
        assert_eq!(most_blurred(&[None, Some(0.1), Some(0.3)], &names), Some((0.3, &names[2])));
        for (got, wanted) in rounding(&q, view).iter().zip(wanted) {
            assert!((got.unwrap() - wanted).abs() < 1e-5, "{got:?} is not {wanted}");
        }
    }
}
