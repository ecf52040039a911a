//! One update: the whole algorithm, in its order.

use super::Learner;
use super::buffers::{Buffers, column_means, log_each};
use super::targets::{bootstrap_own_costs, discount, draw};
use crate::loss::{
    check_finite, check_finite_log_probs, check_finite_losses, margin, squared_error_grad,
    squared_errors,
};
use crate::{Actor, BoundQuery, Config, Net, Observer, QView, Result, Rng, Smoothing};

impl Learner {
    /// One update on one batch: the whole algorithm, in order.
    pub(super) fn update_once(&mut self, log: &mut dyn Observer) -> Result<()> {
        self.updates += 1;
        let tracking = self.updates.is_multiple_of(self.config.target_period);
        let tau = if tracking { self.config.tau as f32 } else { 0.0 };
        self.replay.sample(self.config.batch, &mut self.streams.batch, &mut self.batch)?;
        if let Some(normaliser) = &self.normaliser {
            normaliser.normalise(&mut self.batch.obs)?;
            normaliser.normalise(&mut self.batch.next_obs)?;
        }
        self.next_actions()?;
        self.targets(log)?;
        self.fit_critics(tau, log)?;
        self.look_at_rounding(log)?;
        if self.updates.is_multiple_of(self.config.actor_delay) {
            self.estimate_costs()?;
            self.improve_actor(log)?;
            self.multiplier.log(self.steps, log);
            self.multiplier.update();
        }
        if tracking {
            self.actor.update_target(tau)?;
        }
        Ok(())
    }

    /// Chooses the batch's next actions.
    fn next_actions(&mut self) -> Result<()> {
        let Buffers { noise, policy_noise, next_action, log_prob, .. } = &mut self.buffers;
        let actions = Actions { action: next_action, policy_noise, log_prob, noise };
        let rng = &mut self.streams.smoothing;
        let next_obs = &self.batch.next_obs;
        target_actions(self.actor.as_mut(), self.config.smoothing, rng, next_obs, actions)?;
        check_finite_log_probs(&self.buffers.log_prob, self.steps)
    }

    /// y = r + gamma (1 - d) (lower bound of the target critics at s', a'): paper eq. 13, with the
    /// terminal mask. On the objective that the entropy bonus belongs to, alpha log pi(a'|s') is
    /// subtracted from the bound.
    fn targets(&mut self, log: &mut dyn Observer) -> Result<()> {
        let critics = self.target_values()?;
        let n = self.objectives.len();
        let shared = self.batch.reward.len();
        let Buffers { next_q, target, log_prob, scratch, mean, .. } = &mut self.buffers;
        let chosen = QView::new(&next_q[..critics * shared], critics, n)?;
        let lower = self.config.lower(chosen, self.multiplier.weights());
        self.projection.project(lower, scratch, &mut target[..shared])?;
        let pessimism = margin(chosen, &target[..shared], self.multiplier.actor_weights());
        log.scalar(self.steps, "pessimism/target", pessimism);
        if let Some(temperature) = &self.temperature {
            let alpha = temperature.alpha() as f32;
            let e = temperature.objective();
            for (row, log_prob) in target[..shared].chunks_exact_mut(n).zip(log_prob) {
                row[e] -= alpha * *log_prob;
            }
        }
        if self.config.own_cost_targets {
            bootstrap_own_costs(target, shared, next_q, &self.is_cost);
        }
        for target in target.chunks_exact_mut(shared) {
            discount(target, &self.batch, self.config.discount as f32);
            check_finite("TD target", target, &self.objectives, self.steps)?;
        }
        log.scalar(self.steps, "clip_rate", scratch.clip_rate());
        column_means(target, mean);
        log_each(log, self.steps, &self.names.target, mean);
        Ok(())
    }

    /// Writes the values at s', a' of the target critics in use to the beginning of `next_q`: all
    /// critics, or a few drawn for this update (REDQ). Returns the number of these critics.
    fn target_values(&mut self) -> Result<usize> {
        let Buffers { next_q, positions, next_action, .. } = &mut self.buffers;
        let next_obs = &self.batch.next_obs;
        let Some(subset) = self.config.subset else {
            self.critic.values(Net::Target, next_obs, next_action, next_q)?;
            return Ok(self.critic.critics());
        };
        draw(&mut self.streams.subset, subset, positions);
        let next_q = &mut next_q[..subset * self.batch.reward.len()];
        self.critic.values_of(Net::Target, &positions[..subset], next_obs, next_action, next_q)?;
        Ok(subset)
    }

    /// One step of all critics towards the TD targets, with the objectives' losses weighted by
    /// FAMO. The target networks then move `tau` of the way to the online ones.
    fn fit_critics(&mut self, tau: f32, log: &mut dyn Observer) -> Result<()> {
        let Self {
            critic,
            famo,
            projection,
            multiplier,
            batch,
            config,
            objectives,
            names,
            steps,
            ..
        } = self;
        let Buffers { scratch, target, losses, loss_weights, bound, mean, .. } = &mut self.buffers;
        let grad = &mut |q: QView<'_>, grad: &mut [f32]| {
            squared_errors(q, target, losses);
            check_finite_losses(losses, objectives, *steps)?;
            match famo {
                Some(famo) => famo.weigh(losses, loss_weights),
                None => loss_weights.fill(1.0),
            }
            squared_error_grad(q, target, loss_weights, grad);
            names.log_values(log, *steps, q);
            projection.project(config.lower(q, multiplier.weights()), scratch, bound)
        };
        critic.fit(&batch.obs, &batch.action, grad, tau)?;
        column_means(bound, mean);
        log_each(log, *steps, &names.bound, mean);
        log_each(log, *steps, &names.loss, losses);
        self.balance_losses(log)
    }

    /// FAMO's step: computes the losses again, on the same batch and targets, after the critics'
    /// step.
    fn balance_losses(&mut self, log: &mut dyn Observer) -> Result<()> {
        let Some(famo) = &mut self.famo else { return Ok(()) };
        let Buffers { target, losses, losses_after, loss_weights, q, .. } = &mut self.buffers;
        self.critic.values(Net::Online, &self.batch.obs, &self.batch.action, q)?;
        squared_errors(QView::new(q, self.critic.critics(), losses.len())?, target, losses_after);
        check_finite_losses(losses_after, &self.objectives, self.steps)?;
        famo.step(losses, losses_after);
        log_each(log, self.steps, &self.names.famo, loss_weights);
        Ok(())
    }

    /// Shows a learning multiplier the mean bound at the replayed actions, from the current
    /// critics.
    fn estimate_costs(&mut self) -> Result<()> {
        if self.multiplier.is_constant() {
            return Ok(());
        }
        let Buffers { q, scratch, bound, mean, .. } = &mut self.buffers;
        // FAMO has just computed them.
        if self.famo.is_none() {
            self.critic.values(Net::Online, &self.batch.obs, &self.batch.action, q)?;
        }
        let q = QView::new(q, self.critic.critics(), self.objectives.len())?;
        let lower = self.config.lower(q, self.multiplier.weights());
        self.projection.project(lower, scratch, bound)?;
        column_means(bound, mean);
        check_finite("cost estimate", mean, &self.objectives, self.steps)?;
        self.multiplier.observe(mean);
        Ok(())
    }

    /// Maximises w . (lower bound at s, a) - alpha w_e log pi(a|s) over the policy's actions a,
    /// with gradients through the critics' mean and disagreement: paper eq. 14, and SAC's entropy
    /// bonus on the objective e it belongs to. Then the temperature's step.
    fn improve_actor(&mut self, log: &mut dyn Observer) -> Result<()> {
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

impl Config {
    /// A query for the critics' bound, as pessimistic as in TD targets.
    pub(super) fn lower<'a>(&self, q: QView<'a>, weights: &'a [f32]) -> BoundQuery<'a> {
        BoundQuery { q, weights, step: -self.pessimism as f32 }
    }
}

/// Actions and what they are made from: a policy's noise and log-probabilities (empty for a
/// deterministic one), and the smoothing noise.
pub(super) struct Actions<'a> {
    pub action: &'a mut [f32],
    pub policy_noise: &'a mut [f32],
    pub log_prob: &'a mut [f32],
    pub noise: &'a mut [f32],
}

/// The actions whose values make TD targets: TD3's smoothed ones, a' = clip(mu'(s') + clip(noise)),
/// or samples of the online policy if it is stochastic.
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
