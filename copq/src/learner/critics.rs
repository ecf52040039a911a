//! The critics' step, and what is read off them afterwards.

use super::Learner;
use super::buffers::{Buffers, column_means, log_each};
use crate::loss::{check_finite, check_finite_losses, squared_error_grad, squared_errors};
use crate::{Net, Observer, QView, Result};

impl Learner {
    /// One step of all critics on the same TD targets, the objectives' losses weighted by FAMO;
    /// then the target networks go `tau` of the way to the online ones.
    pub(super) fn fit_critics(&mut self, tau: f32, log: &mut dyn Observer) -> Result<()> {
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

    /// FAMO's step: the losses again, on the same batch and targets, after the critics have moved.
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

    /// Shows a learning multiplier the mean bound at the replayed actions, from the critics as they
    /// now are.
    pub(super) fn estimate_costs(&mut self) -> Result<()> {
        if self.multiplier.is_constant() {
            return Ok(());
        }
        let Buffers { q, scratch, bound, mean, .. } = &mut self.buffers;
        // FAMO has just asked for them.
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
}
