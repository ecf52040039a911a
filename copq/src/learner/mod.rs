//! The one learner: every off-policy method of copq is a [`Method`](crate::Method) given to it.

use std::fmt;
use std::sync::Arc;

use crate::policy::exported;
use crate::temperature::Temperature;
use crate::{
    Actor, Batch, Config, Critic, EnvSpec, Explore, Famo, Multiplier, Normaliser, Observer,
    Projection, Replay, Result,
};
use buffers::{Buffers, Names};
use streams::Streams;

mod agent;
mod buffers;
mod build;
mod critics;
mod policy;
mod streams;
mod targets;

/// Learns a policy and a vector of values from replayed experience: sample, next actions, targets,
/// fit the critics, every so often improve the actor; targets follow.
pub struct Learner {
    config: Config,
    seed: u64,
    /// The method's name, and the task.
    name: String,
    spec: EnvSpec,
    objectives: Vec<String>,
    /// Whether each objective is a cost.
    is_cost: Vec<bool>,
    actor: Box<dyn Actor>,
    critic: Box<dyn Critic>,
    projection: Arc<dyn Projection>,
    explore: Box<dyn Explore>,
    /// Explores until the first update.
    warm_up: Box<dyn Explore>,
    multiplier: Box<dyn Multiplier>,
    temperature: Option<Temperature>,
    famo: Option<Famo>,
    normaliser: Option<Normaliser>,
    replay: Replay,
    streams: Streams,
    /// Environment steps observed and updates done.
    steps: u64,
    updates: u64,
    batch: Batch,
    /// One observation as the networks see it.
    obs: Vec<f32>,
    buffers: Buffers,
    names: Names,
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
    /// One update on one batch: the whole algorithm, in order.
    fn update_once(&mut self, log: &mut dyn Observer) -> Result<()> {
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

    /// Writes the policy to a small file, without the replay: [`Policy::read`](crate::Policy::read)
    /// reads it back.
    pub fn save_policy(&self, path: impl AsRef<std::path::Path>) -> Result<()> {
        let kind = self.config.actor();
        let networks = &self.config.networks;
        exported(self.actor.as_ref(), self.normaliser.as_ref(), &self.spec, networks, kind)?
            .write_file(path)
    }

    /// Updates done so far.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// The experience gathered so far.
    pub fn replay(&self) -> &Replay {
        &self.replay
    }
}
