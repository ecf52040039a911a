//! The one learner: every off-policy method of copq is a [`Method`](crate::Method) given to it.

use std::fmt;
use std::sync::Arc;

use crate::policy::{About, begin_with, exported};
use crate::temperature::Temperature;
use crate::{
    Actor, Batch, Config, Critic, EnvSpec, Explore, Famo, Multiplier, Normaliser, Projection,
    Replay, Result, State,
};
use buffers::{Buffers, Names};
pub use estimate::QEstimate;
use scales::Scales;
use streams::Streams;

mod agent;
mod buffers;
mod build;
mod estimate;
mod rounding;
pub(crate) mod scales;
mod streams;
mod targets;
mod update;

/// Learns a policy and a vector of values from replayed experience. An update samples a batch,
/// chooses next actions, computes targets, fits the critics, improves the actor every so often, and
/// moves the target networks.
///
/// [`Trainer`](crate::Trainer) drives it. By hand, it works like this:
///
/// ```
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let backend = Still;
/// use copq::{Agent, EnvSpec, Learner, Method, Mode, Outcome, Silent, Transition};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("speed", 1.0);
/// let method = Method::cop_td3().warm_up(10);
/// let mut learner = Learner::new(method, &spec, &backend, 0)?; // `copq_candle::Candle::default()`
///
/// let obs = [0.1, 0.2];
/// let mut action = [0.0];
/// for _ in 0..12 {
///     learner.act(&obs, Mode::Explore, &mut action)?;
///     let (action, reward, outcome) = (&action, &[1.0, 0.5], Outcome::Running);
///     learner.observe(Transition { obs: &obs, action, reward, next_obs: &obs, outcome })?;
///     learner.update(&mut Silent)?; // does nothing before the tenth step
/// }
/// assert_eq!((learner.replay().len(), learner.updates()), (12, 3));
/// # Ok::<(), copq::Error>(())
/// ```
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
    /// The environment step of the first update, or of the first after the replay was lost.
    first_update: u64,
    batch: Batch,
    /// One observation as the networks see it.
    obs: Vec<f32>,
    buffers: Buffers,
    names: Names,
    scales: Scales,
    has_warned_of_rounding: bool,
    /// Whether it resumed from a checkpoint without its replay and has not reported that yet.
    has_lost_replay: bool,
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
    /// Writes the policy to a small file, without the replay: [`Policy::read`](crate::Policy::read)
    /// reads it back.
    pub fn save_policy(&self, path: impl AsRef<std::path::Path>) -> Result<()> {
        exported(self.actor.as_ref(), self.normaliser.as_ref(), &self.about())?.write_file(path)
    }

    /// Starts with the weights and the normaliser of a policy that [`Learner::save_policy`] wrote,
    /// given the content of its file ([`State::read_file`]). The policy may be of a different
    /// method or task of the same robot. Critics, optimisers and replay start afresh. So does the
    /// warm-up, in which the policy acts only with [`WarmUp::Policy`](crate::WarmUp). A different
    /// kind of policy is an error, and so is one for a different environment.
    pub fn start_from(&mut self, policy: &State) -> Result<()> {
        let about = self.about();
        begin_with(policy, &about, self.actor.as_mut(), &mut self.normaliser)
    }

    /// The description in its policy's file.
    fn about(&self) -> About {
        About::new(&self.spec, &self.config.networks, self.config.actor(), Some(&self.name))
    }

    /// The settings that it learns with.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The task that it was made for.
    pub fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    /// The current scalarisation weights, one per objective. With multipliers, a cost's weight is
    /// minus its multiplier.
    pub fn weights(&self) -> &[f32] {
        self.multiplier.weights()
    }

    /// The current temperature alpha of the entropy bonus, if there is one.
    pub fn temperature(&self) -> Option<f64> {
        self.temperature.as_ref().map(Temperature::alpha)
    }

    /// Environment steps observed so far.
    pub fn steps(&self) -> u64 {
        self.steps
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
