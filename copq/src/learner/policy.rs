//! The policy's part in an update: its next actions, and its improvement.

use super::Learner;
use super::buffers::Buffers;
use crate::loss::margin;
use crate::{BoundQuery, Net, Observer, QView, Result};

impl Learner {
    /// a' = clip(mu'(s') + clip(noise)), TD3's smoothed target actions; of a stochastic policy a
    /// sample of the online one.
    pub(super) fn next_actions(&mut self) -> Result<()> {
        let Buffers { noise, policy_noise, next_action, log_prob, .. } = &mut self.buffers;
        let next_obs = &self.batch.next_obs;
        if policy_noise.is_empty() {
            self.actor.mode(Net::Target, next_obs, next_action)?;
        } else {
            self.streams.smoothing.fill_normal(policy_noise);
            self.actor.sample(Net::Online, next_obs, policy_noise, next_action, log_prob)?;
        }
        if let Some(smoothing) = self.config.smoothing {
            self.streams.smoothing.fill_normal(noise);
            smoothing.add(noise, next_action);
        }
        Ok(())
    }

    /// Maximises w . (lower bound at s, a) - alpha w_e log pi(a|s) over the policy's actions a,
    /// with gradients through the critics' mean and disagreement: paper eq. 14, and SAC's entropy
    /// bonus on the objective e it belongs to. Then the temperature's step.
    pub(super) fn improve_actor(&mut self, log: &mut dyn Observer) -> Result<()> {
        let Self {
            actor, critic, projection, multiplier, temperature, batch, config, steps, ..
        } = self;
        let Buffers { scratch, bound, grad_bound, policy_noise, .. } = &mut self.buffers;
        let rows = config.batch as f64;
        let weights = multiplier.actor_weights();
        for row in grad_bound.chunks_exact_mut(weights.len()) {
            row.iter_mut().zip(weights).for_each(|(grad, w)| *grad = (-w / rows) as f32);
        }
        let grad_log_prob =
            temperature.as_ref().map_or(0.0, |t| t.alpha() * weights[t.objective()] / rows);
        let step = -config.actor_pessimism as f32;
        let mut mean_log_prob = 0.0;
        let mut pessimism = 0.0;
        self.streams.smoothing.fill_normal(policy_noise);
        actor.improve(&batch.obs, policy_noise, &mut |sample, grad| {
            if let (Some(log_prob), Some(grad)) = (sample.log_prob, grad.log_prob) {
                mean_log_prob = log_prob.iter().map(|&x| f64::from(x)).sum::<f64>() / rows;
                grad.fill(grad_log_prob as f32);
            }
            let grad_q = &mut |q: QView<'_>, grad_q: &mut [f32]| {
                let lower = BoundQuery { q, weights: multiplier.weights(), step };
                projection.project(lower, scratch, bound)?;
                pessimism = margin(q, bound, weights);
                projection.vjp(lower, scratch, grad_bound, grad_q)
            };
            critic.action_grad(&batch.obs, sample.action, grad_q, grad.action)
        })?;
        let scalarised =
            |row: &[f32]| row.iter().zip(weights).map(|(&b, w)| f64::from(b) * w).sum::<f64>();
        log.scalar(
            *steps,
            "actor/objective",
            bound.chunks_exact(weights.len()).map(scalarised).sum::<f64>() / rows,
        );
        log.scalar(*steps, "pessimism/actor", pessimism);
        if let Some(temperature) = temperature {
            log.scalar(*steps, "actor/entropy", -mean_log_prob);
            log.scalar(*steps, "actor/temperature", temperature.alpha());
            temperature.update(mean_log_prob);
        }
        Ok(())
    }
}
