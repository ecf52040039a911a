//! The policy's part in an update: its next actions, and its improvement.

use super::Learner;
use super::buffers::Buffers;
use crate::loss::margin;
use crate::{Actor, BoundQuery, Net, Observer, QView, Result, Rng, Smoothing};

/// Actions and what they are made of: a policy's noise and log-probabilities, none of a
/// deterministic one, and the noise that smooths.
pub(super) struct Actions<'a> {
    pub action: &'a mut [f32],
    pub policy_noise: &'a mut [f32],
    pub log_prob: &'a mut [f32],
    pub noise: &'a mut [f32],
}

/// The actions whose values TD targets are of: a' = clip(mu'(s') + clip(noise)), TD3's smoothed
/// ones; of a stochastic policy samples of the online one.
pub(super) fn target_actions(
    actor: &mut dyn Actor,
    smoothing: Option<Smoothing>,
    rng: &mut Rng,
    obs: &[f32],
    actions: Actions<'_>,
) -> Result<()> {
    let Actions { action, policy_noise, log_prob, noise } = actions;
    if policy_noise.is_empty() {
        actor.mode(Net::Target, obs, action)?;
    } else {
        rng.fill_normal(policy_noise);
        actor.sample(Net::Online, obs, policy_noise, action, log_prob)?;
    }
    if let Some(smoothing) = smoothing {
        rng.fill_normal(noise);
        smoothing.add(noise, action);
    }
    Ok(())
}

impl Learner {
    /// Chooses the batch's next actions.
    pub(super) fn next_actions(&mut self) -> Result<()> {
        let Buffers { noise, policy_noise, next_action, log_prob, .. } = &mut self.buffers;
        let actions = Actions { action: next_action, policy_noise, log_prob, noise };
        let rng = &mut self.streams.smoothing;
        let next_obs = &self.batch.next_obs;
        target_actions(self.actor.as_mut(), self.config.smoothing, rng, next_obs, actions)
    }

    /// Maximises w . (lower bound at s, a) - alpha w_e log pi(a|s) over the policy's actions a,
    /// with gradients through the critics' mean and disagreement: paper eq. 14, and SAC's entropy
    /// bonus on the objective e it belongs to. Then the temperature's step.
    pub(super) fn improve_actor(&mut self, log: &mut dyn Observer) -> Result<()> {
        let Self {
            actor, critic, projection, multiplier, temperature, batch, config, steps, ..
        } = self;
        let Buffers { scratch, actor_bound: bound, grad_bound, policy_noise, .. } =
            &mut self.buffers;
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
