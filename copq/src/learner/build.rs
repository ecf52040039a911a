//! Builds a learner from a configuration, networks and strategies that fit each other and the task.

use super::Learner;
use super::buffers::{Buffers, Names};
use super::scales::Scales;
use super::streams::Streams;
use crate::error::check_len;
use crate::multiplier::FixedWeights;
use crate::projection::by_name;
use crate::temperature::Temperature;
use crate::{
    Actor, ActorKind, Backend, Batch, Config, Critic, EnvSpec, Error, Explore, Famo, GaussianNoise,
    Method, Multiplier, Normaliser, Objective, Optimistic, PolicySamples, Projection, Replay,
    Result, Rng, Stream, UniformActions, WarmUp, memory,
};

impl Learner {
    /// Makes a learner for a method and a task, with networks from a backend. Every random number
    /// comes from `seed`.
    ///
    /// It explores with Gaussian noise or a stochastic policy's own samples, shifted towards an
    /// upper bound if [`Config::optimism`] is set. Its scalarisation weights are the task's, or
    /// come from the multipliers of [`Config::constraint`]. Swap exploration and multipliers with
    /// [`Learner::explore`] and [`Learner::multiplier`].
    ///
    /// # Errors
    ///
    /// Settings or a task description that cannot be used, a constraint for a task without costs,
    /// networks that the backend cannot make, or more memory than the machine has.
    pub fn new(method: Method, spec: &EnvSpec, backend: &dyn Backend, seed: u64) -> Result<Self> {
        method.config.check()?;
        spec.check()?;
        memory::check(&method.config, spec, method.critics.count(spec))?;
        if method.config.subset.is_some() {
            method.critics.check_subset(spec)?;
        }
        let networks = &method.config.networks;
        let kind = method.actor();
        let mut rng = Rng::new(seed, Stream::Init);
        let actor = |rng: &mut Rng| backend.actor(spec, networks, kind, rng);
        let critics = |rng: &mut Rng| method.critics.build(backend, spec, networks, rng);
        // Gaussian methods without a subset draw the actor's weights first; all others draw the
        // critics' first. This order stays as it is so that stored seeds repeat.
        let (critic, actor) = if kind == ActorKind::Gaussian && method.config.subset.is_none() {
            let actor = actor(&mut rng)?;
            (critics(&mut rng)?, actor)
        } else {
            (critics(&mut rng)?, actor(&mut rng)?)
        };
        Self::with_networks(method, spec, critic, actor, seed)
    }

    /// The same with your own networks, which replace the method's.
    pub fn with_networks(
        method: Method,
        spec: &EnvSpec,
        critic: Box<dyn Critic>,
        actor: Box<dyn Actor>,
        seed: u64,
    ) -> Result<Self> {
        let Method { config, bound, name, .. } = method;
        config.check()?;
        spec.check()?;
        // The size of the caller's networks is not known, but a batch goes through at least one.
        memory::check(&config, spec, 1)?;
        // Report a task that does not suit the method before critics that do not suit the task.
        let multiplier = multiplier(&config, spec)?;
        check_parts(&config, spec, critic.as_ref(), actor.as_ref())?;
        check_bounds(&config, bound.as_ref(), critic.as_ref())?;
        let entropy = config.entropy.as_ref();
        let temperature = entropy.map(|entropy| Temperature::new(entropy, spec)).transpose()?;
        let famo = config.famo.filter(|famo| famo.separate || critic.shared());
        let famo = famo.map(|famo| Famo::new(famo, spec.objectives.len())).transpose()?;
        Ok(Self {
            replay: Replay::new(spec, config.capacity)?,
            projection: bound,
            name,
            spec: spec.clone(),
            seed,
            explore: exploration(&config, actor.as_ref())?,
            warm_up: warm_up(&config, actor.as_ref()),
            normaliser: config.normalise.then(|| Normaliser::new(spec.obs_len)),
            multiplier,
            temperature,
            streams: Streams::new(seed),
            obs: vec![0.0; spec.obs_len],
            buffers: Buffers::new(&config, actor.as_ref(), critic.as_ref()),
            is_cost: spec.objectives.iter().map(|objective| objective.is_cost()).collect(),
            names: Names::new(&spec.names(), critic.shared()),
            objectives: spec.names().into_iter().map(str::to_owned).collect(),
            steps: 0,
            updates: 0,
            first_update: config.start_steps,
            scales: Scales::new(spec),
            has_warned_of_rounding: false,
            has_lost_replay: false,
            batch: Batch::with_capacity(spec, config.batch),
            config,
            actor,
            critic,
            famo,
        })
    }

    /// Swaps the exploration rule, which acts from step [`Config::start_steps`] on; before that,
    /// [`Config::warm_up`] does. A checkpoint does not record the rule, so give a method with your
    /// own rule its own name ([`Method::named`]).
    pub fn explore(mut self, explore: impl Explore + 'static) -> Self {
        self.explore = Box::new(explore);
        self
    }

    /// Swaps the source of the scalarisation weights. As with [`Learner::explore`], give the method
    /// its own name, to tell its checkpoints from others. A stochastic policy needs a positive
    /// weight for the reward that its entropy bonus is added to.
    pub fn multiplier(mut self, multiplier: impl Multiplier + 'static) -> Result<Self> {
        check_len("the multiplier's weights", multiplier.weights().len(), self.objectives.len())?;
        check_len(
            "the multiplier's weights for the actor",
            multiplier.actor_weights().len(),
            self.objectives.len(),
        )?;
        if let Some(objective) = self.temperature.as_ref().map(Temperature::objective) {
            let weight = multiplier.actor_weights()[objective];
            if weight.is_nan() || weight <= 0.0 {
                let what = format!("the multiplier's weight of '{}'", self.objectives[objective]);
                return Err(Error::invalid(
                    what,
                    "more than 0, because the entropy bonus is added to it",
                    weight,
                ));
            }
        }
        self.multiplier = Box::new(multiplier);
        Ok(self)
    }
}

/// The task's weights, or the multipliers that a configuration describes.
fn multiplier(config: &Config, spec: &EnvSpec) -> Result<Box<dyn Multiplier>> {
    match &config.constraint {
        Some(constraint) => constraint.multiplier(spec, config.discount),
        None => Ok(Box::new(FixedWeights::new(&weights(spec))?)),
    }
}

/// The task's weights. A cost without a weight gets -0, which tells bounds that it is a cost.
fn weights(spec: &EnvSpec) -> Vec<f32> {
    let at_rest = |o: &Objective| o.is_cost() && o.weight == 0.0;
    spec.objectives.iter().map(|o| if at_rest(o) { -0.0 } else { o.weight }).collect()
}

/// The rule that acts before the first update.
fn warm_up(config: &Config, actor: &dyn Actor) -> Box<dyn Explore> {
    match config.warm_up {
        WarmUp::Uniform => Box::new(UniformActions),
        WarmUp::Policy => own_noise(config, actor),
    }
}

/// The exploration that a configuration describes.
fn exploration(config: &Config, actor: &dyn Actor) -> Result<Box<dyn Explore>> {
    Ok(match &config.optimism {
        Some(optimism) => {
            Box::new(Optimistic::new(optimism.clone(), config.exploration_std as f32)?)
        }
        None => own_noise(config, actor),
    })
}

/// Exploration by the policy alone: with Gaussian noise, or with the samples of a stochastic one.
fn own_noise(config: &Config, actor: &dyn Actor) -> Box<dyn Explore> {
    match actor.noise_len() {
        0 => Box::new(GaussianNoise { std: config.exploration_std as f32 }),
        _ => Box::<PolicySamples>::default(),
    }
}

/// An error for a bound that reads covariances over separate networks: which network of one
/// objective is paired with which of another is arbitrary, and so are the covariances.
fn check_bounds(config: &Config, bound: &dyn Projection, critic: &dyn Critic) -> Result<()> {
    if critic.shared() || critic.objectives() == 1 {
        return Ok(());
    }
    let upper = config.optimism.as_ref().and_then(|optimism| optimism.projection.as_deref());
    let upper = upper.map(by_name).transpose()?;
    match [Some(bound), upper.as_deref()].into_iter().flatten().find(|b| b.reads_covariances()) {
        Some(bound) => {
            let wanted = "one that does not read covariances, for objectives with separate critics";
            Err(Error::invalid("the bound", wanted, bound.name()))
        }
        None => Ok(()),
    }
}

/// An error that names the first part that does not fit the others.
fn check_parts(
    config: &Config,
    spec: &EnvSpec,
    critic: &dyn Critic,
    actor: &dyn Actor,
) -> Result<()> {
    check_len("the critic's objectives", critic.objectives(), spec.objectives.len())?;
    check_len("the actor's action", actor.action_len(), spec.action_len())?;
    if critic.critics() == 0 {
        return Err(Error::invalid("the critic ensemble", "at least 1 critic", 0));
    }
    if config.entropy.is_some() && actor.noise_len() == 0 {
        return Err(Error::invalid(
            "the actor",
            "a stochastic policy, for the entropy bonus",
            "a deterministic one",
        ));
    }
    match config.subset {
        Some(subset) if subset > critic.critics() => {
            Err(Error::invalid("subset", format!("at most {} critics", critic.critics()), subset))
        }
        _ => Ok(()),
    }
}
