//! Learning from a finished epoch: multipliers, advantages, the method's steps, a report.

use super::episodes::Fresh;
use super::multiplier::Multiplier;
use super::normal::mean_entropy;
use super::{Learner, Report, update};
use crate::{Error, Observer, Result, Rng};

impl Learner {
    /// The mean costs of the last finished episodes; none if there are none.
    pub(super) fn mean_costs(&self) -> Option<Vec<f64>> {
        // The newest first: the order of a sum changes its bits.
        let mut last = Fresh::new(self.costs.len());
        self.window.iter().rev().take(self.config.window).for_each(|costs| last.add(costs));
        last.mean()
    }

    /// A finished epoch's learning: multipliers, advantages, steps.
    pub(super) fn learn(&mut self, log: &mut dyn Observer) -> Result<()> {
        self.warn_of_short_paths(log);
        if let Some(mean) = self.mean_costs() {
            let multipliers = self.multipliers.iter_mut().zip(&self.limits);
            multipliers.zip(mean).for_each(|((rule, &limit), cost)| rule.update(cost, limit));
        }
        let Self { epoch, config, policy, critics, order, .. } = self;
        let multipliers: Vec<_> = self.multipliers.iter().map(Multiplier::value).collect();
        let rows = epoch.finish(config.discount, config.gae);
        let report = update(
            config,
            rows,
            &multipliers,
            config.actor_lr(self.epochs),
            policy.as_mut(),
            critics,
            &mut |rows| shuffle(order, rows),
        )?;
        self.check_finite(&report)?;
        self.log(&report, log);
        self.epoch.clear();
        self.epochs += 1;
        self.fresh = Fresh::new(self.costs.len());
        Ok(())
    }

    /// Warns if an epoch can be shorter than an episode: every epoch begins with new ones.
    fn warn_of_short_paths(&self, log: &mut dyn Observer) {
        let steps = self.config.steps_per_epoch / self.envs.len();
        let horizon = self.spec.horizon;
        if self.epochs > 0 || steps >= horizon {
            return;
        }
        let lost = match self.config.saute {
            Some(saute) => {
                // The rates at which a budget is just spent in an epoch's steps and in an episode's.
                let rate = |steps: usize| 1.0 / saute.budget(steps as f64, steps);
                format!(
                    "a budget lasts an epoch at {:.1} times the rate that the limit allows",
                    rate(steps) / rate(horizon)
                )
            }
            None if self.multipliers.is_empty() => "later states are never seen".to_owned(),
            None => "costs of longer episodes are never seen".to_owned(),
        };
        let text = format!(
            "an epoch has {steps} steps of each environment, and an episode of '{}' may take \
             {horizon}: {lost}; raise steps_per_epoch or use fewer environments",
            self.spec.name
        );
        log.warn(self.steps, &text);
    }

    fn check_finite(&self, report: &Report) -> Result<()> {
        let Report { kl, second_kl, critic_losses, .. } = report;
        for (name, values) in [
            ("the policy's divergence after pass", kl),
            ("the second step's divergence after pass", second_kl),
            ("the loss of critic", critic_losses),
        ] {
            if let Some(i) = values.iter().position(|x| !x.is_finite()) {
                let what = format!("{name} {} of epoch {}", i + 1, self.epochs);
                let wanted = "a finite number (try lower step sizes, or rewards near 1)";
                return Err(Error::invalid(what, wanted, values[i]));
            }
        }
        Ok(())
    }

    fn log(&self, report: &Report, log: &mut dyn Observer) {
        let step = self.steps;
        let mut put = |name: &str, value: f64| log.scalar(step, name, value);
        put("policy/kl", report.kl.last().copied().unwrap_or(0.0));
        put("policy/passes", report.kl.len() as f64);
        if self.config.second.is_some() {
            put("policy/second_kl", report.second_kl.last().copied().unwrap_or(0.0));
            put("policy/second_passes", report.second_kl.len() as f64);
        }
        if self.config.natural.is_none() {
            put("policy/clip_share", report.clip_share);
        }
        put("policy/entropy", mean_entropy(self.policy.log_std()));
        let stds = self.policy.log_std().iter().map(|&log| libm::exp(f64::from(log)));
        put("policy/std", stds.sum::<f64>() / self.policy.log_std().len() as f64);
        if self.config.natural.is_none() {
            put("policy/lr", self.config.actor_lr(self.epochs));
        }
        let names = std::iter::once("reward")
            .chain(self.costs.iter().map(|&cost| self.objectives[cost].as_str()));
        for (k, (name, loss)) in names.clone().zip(&report.critic_losses).enumerate() {
            put(&format!("critic_loss/{name}"), *loss);
            let [spread, explained] = self.epoch.quality(k);
            put(&format!("advantage_std/{name}"), spread);
            put(&format!("explained_variance/{name}"), explained);
        }
        for (name, lambda) in names.clone().skip(1).zip(self.multipliers()) {
            put(&format!("multiplier/{name}"), lambda);
        }
        for (kind, costs) in [("window", self.mean_costs()), ("epoch", self.fresh.mean())] {
            for (name, cost) in names.clone().skip(1).zip(costs.iter().flatten()) {
                put(&format!("cost_{kind}/{name}"), *cost);
            }
        }
    }
}

/// The Fisher-Yates shuffle.
fn shuffle(rng: &mut Rng, rows: &mut [usize]) {
    for i in (1..rows.len()).rev() {
        rows.swap(i, rng.below(i + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stream;

    /// A shuffle that leaves no row in its place, or does nothing, would go unnoticed in training.
    #[test]
    fn every_order_of_the_rows_comes_equally_often() {
        let mut rng = Rng::new(1, Stream::Batch);
        let mut counts = std::collections::BTreeMap::new();
        for _ in 0..24_000 {
            let mut rows = [0, 1, 2, 3];
            shuffle(&mut rng, &mut rows);
            *counts.entry(rows).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 24);
        assert!(counts.values().all(|n| (850..1150).contains(n)), "{counts:?}");
    }
}
