//! The one learner: every off-policy method of copq is a [`Config`] and a few strategies given to it.

use std::fmt;

use crate::error::check_len;
use crate::loss::{finite, finite_losses, squared_error_grad, squared_errors};
use crate::multiplier::Fixed;
use crate::projection::{Cholesky, Directions};
use crate::{
    Actor, Batch, Bound, Config, Critic, EnvSpec, Error, Explore, Famo, Gaussian, Multiplier, Net, Observer,
    Projection, QView, Replay, Result, Rng, Stream,
};
use work::{Names, Work, column_means, log_each};

mod agent;
mod work;

/// Learns a policy and a vector of values from replayed experience:
/// sample, next actions, targets, fit the critics, every so often improve the actor, track.
pub struct Learner {
    config: Config,
    objectives: Vec<String>,
    actor: Box<dyn Actor>,
    critic: Box<dyn Critic>,
    projection: Box<dyn Projection>,
    explore: Box<dyn Explore>,
    multiplier: Box<dyn Multiplier>,
    famo: Option<Famo>,
    replay: Replay,
    streams: Streams,
    /// Environment steps observed and updates done.
    steps: u64,
    updates: u64,
    batch: Batch,
    work: Work,
    names: Names,
}

#[derive(Debug)]
struct Streams {
    explore: Rng,
    smoothing: Rng,
    batch: Rng,
}

impl fmt::Debug for Learner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Learner")
            .field("config", &self.config)
            .field("objectives", &self.objectives)
            .field("projection", &self.projection)
            .field("explore", &self.explore)
            .field("multiplier", &self.multiplier)
            .field("critics", &self.critic.critics())
            .field("steps", &self.steps)
            .field("updates", &self.updates)
            .finish_non_exhaustive()
    }
}

impl Learner {
    /// A learner with the Cholesky projection, Gaussian exploration and the task's fixed weights; swap any of them
    /// with [`Learner::projection`], [`Learner::explore`] and [`Learner::multiplier`].
    pub fn new(
        config: Config,
        spec: &EnvSpec,
        critic: Box<dyn Critic>,
        actor: Box<dyn Actor>,
        seed: u64,
    ) -> Result<Self> {
        config.check()?;
        spec.check()?;
        let (n, rows) = (spec.objectives.len(), config.batch);
        check_len("the critic's objectives", critic.objectives(), n)?;
        check_len("the actor's action", actor.action(), spec.action())?;
        if critic.critics() == 0 {
            return Err(Error::invalid("the critic ensemble", "at least 1 critic", 0));
        }
        let famo = config.famo.map(|famo| Famo::new(famo, n)).transpose()?;
        let mut batch = Batch::default();
        batch.reserve(rows, spec.observation, spec.action(), n);
        Ok(Self {
            replay: Replay::new(config.capacity, spec.observation, spec.action(), n)?,
            projection: Box::new(Cholesky),
            explore: Box::new(Gaussian { std: config.exploration_std as f32 }),
            multiplier: Box::new(Fixed::new(&spec.weights)?),
            streams: Streams {
                explore: Rng::new(seed, Stream::Explore),
                smoothing: Rng::new(seed, Stream::Smoothing),
                batch: Rng::new(seed, Stream::Batch),
            },
            work: Work::new(rows, spec.action(), n, critic.critics()),
            names: Names::new(&spec.objectives),
            objectives: spec.objectives.clone(),
            steps: 0,
            updates: 0,
            config,
            actor,
            critic,
            famo,
            batch,
        })
    }

    /// Swaps the projection.
    pub fn projection(mut self, projection: impl Projection + 'static) -> Self {
        self.projection = Box::new(projection);
        self
    }

    /// Swaps the exploration rule.
    pub fn explore(mut self, explore: impl Explore + 'static) -> Self {
        self.explore = Box::new(explore);
        self
    }

    /// Swaps the source of the scalarisation weights.
    pub fn multiplier(mut self, multiplier: impl Multiplier + 'static) -> Result<Self> {
        check_len("the multiplier's weights", multiplier.weights().len(), self.objectives.len())?;
        self.multiplier = Box::new(multiplier);
        Ok(self)
    }

    /// Updates done so far.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// The experience gathered so far.
    pub fn replay(&self) -> &Replay {
        &self.replay
    }

    /// One update on one batch: the whole algorithm, in order.
    fn update_once(&mut self, log: &mut dyn Observer) -> Result<()> {
        self.replay.sample(self.config.batch, &mut self.streams.batch, &mut self.batch)?;
        self.next_actions()?;
        self.targets(log)?;
        self.fit_critics(log)?;
        self.updates += 1;
        if self.updates.is_multiple_of(self.config.actor_delay) {
            self.improve_actor(log)?;
        }
        if self.updates.is_multiple_of(self.config.target_period) {
            self.critic.track(self.config.tau as f32)?;
            self.actor.track(self.config.tau as f32)?;
        }
        Ok(())
    }

    /// a' = clip(mu'(s') + clip(noise)): TD3's smoothed target actions.
    fn next_actions(&mut self) -> Result<()> {
        let Work { noise, next_action, .. } = &mut self.work;
        self.actor.sample(Net::Target, &self.batch.next_obs, &[], next_action, &mut [])?;
        if let Some(smoothing) = self.config.smoothing {
            let (std, clip) = (smoothing.std as f32, smoothing.clip as f32);
            self.streams.smoothing.fill_normal(noise);
            for (action, noise) in next_action.iter_mut().zip(noise) {
                *action = (*action + (std * *noise).clamp(-clip, clip)).clamp(-1.0, 1.0);
            }
        }
        Ok(())
    }

    /// y = r + gamma (1 - d) (lower bound of the target critics at s', a'): paper eq. 13, with the terminal mask.
    fn targets(&mut self, log: &mut dyn Observer) -> Result<()> {
        let n = self.objectives.len();
        let Work { q, target, next_action, scratch, mean, .. } = &mut self.work;
        self.critic.values(Net::Target, &self.batch.next_obs, next_action, q)?;
        let q = QView::new(q, self.critic.critics(), n)?;
        let bound = Bound { q, weights: self.multiplier.weights(), step: -self.config.pessimism as f32 };
        self.projection.project(bound, scratch, target)?;
        let gamma = self.config.discount as f32;
        for (row, target) in target.chunks_exact_mut(n).enumerate() {
            let discount = gamma * self.batch.alive[row];
            for (y, r) in target.iter_mut().zip(&self.batch.reward[row * n..]) {
                *y = r + discount * *y;
            }
        }
        finite("TD target", target, &self.objectives, self.steps)?;
        log.scalar(self.steps, "clip_rate", scratch.clip_rate());
        column_means(target, mean);
        log_each(log, self.steps, &self.names.target, mean);
        Ok(())
    }

    /// One step of all critics on the same targets, the objectives' losses weighted by FAMO; then the multiplier's.
    fn fit_critics(&mut self, log: &mut dyn Observer) -> Result<()> {
        let Self { critic, famo, projection, multiplier, batch, config, objectives, names, steps, .. } = self;
        let Work { scratch, target, losses, loss_weights, bound, mean, .. } = &mut self.work;
        critic.fit(&batch.obs, &batch.action, &mut |q, grad| {
            squared_errors(q, target, losses);
            finite_losses(losses, objectives, *steps)?;
            match famo {
                Some(famo) => famo.weigh(losses, loss_weights),
                None => loss_weights.fill(1.0),
            }
            squared_error_grad(q, target, loss_weights, grad);
            names.log_values(log, *steps, q);
            let lower = Bound { q, weights: multiplier.weights(), step: -config.pessimism as f32 };
            projection.project(lower, scratch, bound)
        })?;
        column_means(bound, mean);
        multiplier.update(mean)?;
        log_each(log, *steps, &names.bound, mean);
        log_each(log, *steps, &names.loss, losses);
        self.balance_losses(log)
    }

    /// FAMO's step: the losses again, on the same batch and targets, after the critics have moved.
    fn balance_losses(&mut self, log: &mut dyn Observer) -> Result<()> {
        let Some(famo) = &mut self.famo else { return Ok(()) };
        let Work { target, losses, losses_after, loss_weights, q, .. } = &mut self.work;
        self.critic.values(Net::Online, &self.batch.obs, &self.batch.action, q)?;
        squared_errors(QView::new(q, self.critic.critics(), losses.len())?, target, losses_after);
        finite_losses(losses_after, &self.objectives, self.steps)?;
        famo.step(losses, losses_after);
        log_each(log, self.steps, &self.names.famo, loss_weights);
        Ok(())
    }

    /// Maximises u . (lower bound at s, pi(s)), with gradients through the mean and the disagreement: paper eq. 14.
    fn improve_actor(&mut self, log: &mut dyn Observer) -> Result<()> {
        let Self { actor, critic, projection, multiplier, batch, config, steps, .. } = self;
        let Work { scratch, bound, grad_bound, direction, .. } = &mut self.work;
        Directions::new(multiplier.weights(), 1, direction.len())?.unit(0, direction);
        let rows = config.batch as f64;
        let n = direction.len();
        for row in grad_bound.chunks_exact_mut(n) {
            row.iter_mut().zip(direction.iter()).for_each(|(grad, u)| *grad = (-u / rows) as f32);
        }
        let step = -config.pessimism as f32;
        actor.improve(&batch.obs, &[], &mut |sample, grad| {
            let grad_q = &mut |q: QView<'_>, grad_q: &mut [f32]| {
                let lower = Bound { q, weights: multiplier.weights(), step };
                projection.project(lower, scratch, bound)?;
                projection.vjp(lower, scratch, grad_bound, grad_q)
            };
            critic.action_grad(&batch.obs, sample.action, grad_q, grad.action)
        })?;
        let objective: f64 = bound
            .chunks_exact(n)
            .map(|row| row.iter().zip(direction.iter()).map(|(&b, u)| f64::from(b) * u).sum::<f64>())
            .sum::<f64>()
            / rows;
        log.scalar(*steps, "actor/objective", objective);
        Ok(())
    }
}
