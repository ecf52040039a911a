//! The one learner: every off-policy method of copq is a [`Config`] and a few strategies given to it.

use std::fmt;

use crate::error::check_len;
use crate::loss::{finite, finite_losses, squared_error_grad, squared_errors};
use crate::multiplier::Fixed;
use crate::projection::{Cholesky, ScalarisedMin};
use crate::temperature::Temperature;
use crate::{
    Actor, Batch, Bound, Config, Critic, EnvSpec, Error, Explore, Famo, Gaussian, Multiplier, Net, Observer,
    Optimistic, Projection, QView, Replay, Result, Rng, Sampled, Stream,
};
use work::{Names, Work, column_means, log_each};

mod agent;
mod targets;
mod work;

/// Learns a policy and a vector of values from replayed experience:
/// sample, next actions, targets, fit the critics, every so often improve the actor, track.
pub struct Learner {
    config: Config,
    objectives: Vec<String>,
    /// Whether each objective is a cost.
    is_cost: Vec<bool>,
    actor: Box<dyn Actor>,
    critic: Box<dyn Critic>,
    projection: Box<dyn Projection>,
    explore: Box<dyn Explore>,
    multiplier: Box<dyn Multiplier>,
    temperature: Option<Temperature>,
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
    subset: Rng,
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
    /// The learner that a configuration describes. It begins with
    ///
    /// * the Cholesky projection, or with [`ScalarisedMin`] if targets draw a subset of the critics: two critics say
    ///   too little of a covariance;
    /// * exploration by Gaussian noise or a stochastic policy's own samples, towards the upper bound of its projection if
    ///   [`Config::optimism`] says so;
    /// * the task's weights, or the multipliers of [`Config::constraint`], which is an error for a task without costs.
    ///
    /// Swap any of them with [`Learner::projection`], [`Learner::explore`] and [`Learner::multiplier`].
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
        if config.entropy.is_some() && actor.noise() == 0 {
            return Err(Error::invalid(
                "the actor",
                "a stochastic policy, for the entropy bonus",
                "a deterministic one",
            ));
        }
        if config.subset.is_some_and(|subset| subset > critic.critics()) {
            return Err(Error::invalid(
                "subset",
                format!("at most {} critics", critic.critics()),
                config.subset.unwrap_or(0),
            ));
        }
        let entropy = config.entropy.as_ref();
        let temperature = entropy.map(|entropy| Temperature::new(entropy, spec)).transpose()?;
        let multiplier: Box<dyn Multiplier> = match &config.constraint {
            Some(constraint) => constraint.multiplier(spec, config.discount)?,
            None => Box::new(Fixed::new(&spec.weights)?),
        };
        let famo = config.famo.map(|famo| Famo::new(famo, n)).transpose()?;
        let mut batch = Batch::default();
        batch.reserve(rows, spec.observation, spec.action(), n);
        Ok(Self {
            replay: Replay::new(config.capacity, spec.observation, spec.action(), n)?,
            projection: if config.subset.is_some() { Box::new(ScalarisedMin) } else { Box::new(Cholesky) },
            explore: exploration(&config, actor.as_ref()),
            multiplier,
            temperature,
            streams: Streams {
                explore: Rng::new(seed, Stream::Explore),
                smoothing: Rng::new(seed, Stream::Smoothing),
                batch: Rng::new(seed, Stream::Batch),
                subset: Rng::new(seed, Stream::Subset),
            },
            work: Work::new(&config, actor.as_ref(), critic.as_ref()),
            is_cost: (0..n).map(|i| spec.limit(i).is_some()).collect(),
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
            self.estimate_costs()?;
            self.improve_actor(log)?;
            self.multiplier.log(self.steps, log);
            self.multiplier.update();
        }
        if self.updates.is_multiple_of(self.config.target_period) {
            self.critic.track(self.config.tau as f32)?;
            self.actor.track(self.config.tau as f32)?;
        }
        Ok(())
    }

    /// a' = clip(mu'(s') + clip(noise)), TD3's smoothed target actions; of a stochastic policy a sample of the online one.
    fn next_actions(&mut self) -> Result<()> {
        let Work { noise, policy_noise, next_action, log_prob, .. } = &mut self.work;
        let net = if policy_noise.is_empty() { Net::Target } else { Net::Online };
        self.streams.smoothing.fill_normal(policy_noise);
        self.actor.sample(net, &self.batch.next_obs, policy_noise, next_action, log_prob)?;
        if let Some(smoothing) = self.config.smoothing {
            let (std, clip) = (smoothing.std as f32, smoothing.clip as f32);
            self.streams.smoothing.fill_normal(noise);
            for (action, noise) in next_action.iter_mut().zip(noise) {
                *action = (*action + (std * *noise).clamp(-clip, clip)).clamp(-1.0, 1.0);
            }
        }
        Ok(())
    }

    /// One step of all critics on the same targets, the objectives' losses weighted by FAMO.
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

    /// Shows a learning multiplier the mean bound at the replayed actions, from the critics as they now are.
    fn estimate_costs(&mut self) -> Result<()> {
        if self.multiplier.is_constant() {
            return Ok(());
        }
        let Work { q, scratch, bound, mean, .. } = &mut self.work;
        self.critic.values(Net::Online, &self.batch.obs, &self.batch.action, q)?;
        let q = QView::new(q, self.critic.critics(), self.objectives.len())?;
        let step = -self.config.pessimism as f32;
        self.projection.project(Bound { q, weights: self.multiplier.weights(), step }, scratch, bound)?;
        column_means(bound, mean);
        finite("cost estimate", mean, &self.objectives, self.steps)?;
        self.multiplier.observe(mean);
        Ok(())
    }

    /// Maximises w . (lower bound at s, a) - alpha w_e log pi(a|s) over the policy's actions a, with gradients through the
    /// critics' mean and disagreement: paper eq. 14, and SAC's entropy bonus on the objective e it belongs to. Then the
    /// temperature's step.
    fn improve_actor(&mut self, log: &mut dyn Observer) -> Result<()> {
        let Self { actor, critic, projection, multiplier, temperature, batch, config, steps, .. } = self;
        let Work { scratch, bound, grad_bound, policy_noise, .. } = &mut self.work;
        let (rows, weights) = (config.batch as f64, multiplier.actor_weights());
        for row in grad_bound.chunks_exact_mut(weights.len()) {
            row.iter_mut().zip(weights).for_each(|(grad, w)| *grad = (-w / rows) as f32);
        }
        let grad_log_prob = temperature.as_ref().map_or(0.0, |t| t.alpha() * weights[t.objective()] / rows);
        let (step, mut mean_log_prob) = (-config.actor_pessimism as f32, 0.0);
        self.streams.smoothing.fill_normal(policy_noise);
        actor.improve(&batch.obs, policy_noise, &mut |sample, grad| {
            mean_log_prob = sample.log_prob.iter().map(|&log_prob| f64::from(log_prob)).sum::<f64>() / rows;
            grad.log_prob.fill(grad_log_prob as f32);
            let grad_q = &mut |q: QView<'_>, grad_q: &mut [f32]| {
                let lower = Bound { q, weights: multiplier.weights(), step };
                projection.project(lower, scratch, bound)?;
                projection.vjp(lower, scratch, grad_bound, grad_q)
            };
            critic.action_grad(&batch.obs, sample.action, grad_q, grad.action)
        })?;
        let scalarised = |row: &[f32]| row.iter().zip(weights).map(|(&b, w)| f64::from(b) * w).sum::<f64>();
        log.scalar(*steps, "actor/objective", bound.chunks_exact(weights.len()).map(scalarised).sum::<f64>() / rows);
        if let Some(temperature) = temperature {
            log.scalar(*steps, "actor/entropy", -mean_log_prob);
            log.scalar(*steps, "actor/temperature", temperature.alpha());
            temperature.update(mean_log_prob);
        }
        Ok(())
    }
}

/// The exploration that a configuration describes.
fn exploration(config: &Config, actor: &dyn Actor) -> Box<dyn Explore> {
    let std = config.exploration_std as f32;
    match (config.optimism, actor.noise()) {
        (Some(optimism), _) => Box::new(Optimistic::own(optimism, std)),
        (None, 0) => Box::new(Gaussian { std }),
        (None, _) => Box::<Sampled>::default(),
    }
}
