//! The one on-policy learner: every method is a [`Method`] given to it.

use std::collections::VecDeque;
use std::fmt;

use super::episodes::{EnvState, Fresh};
use super::epoch::Epoch;
use super::multiplier::Multiplier;
use super::normal::Deviations;
use super::saute::shows_budgets;
use super::{Config, GaussianPolicy, Method, StateValue};
use crate::learner::scales::Scales;
use crate::memory;
use crate::policy::{About, begin_with, exported};
use crate::{ActorKind, Backend, EnvSpec, Error, Normaliser, Result, Rng, State, Stream};

/// Learns a policy, and the values of its observations, from epochs of its own steps.
///
/// It is an [`Agent`](crate::Agent): [`Trainer`](crate::Trainer) drives it, run folders save it in
/// the middle of an epoch, and it resumes bit for bit. An epoch begins with a new episode; the
/// episode that it cuts short counts only for its steps.
///
/// ```
/// use copq::EnvSpec;
/// use copq::on_policy::{Learner, Method};
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let backend = Still;
///
/// let spec = EnvSpec::new("cart", 2, 1).cost("speed", 100.0).reward("progress", 1.0);
/// let learner = Learner::new(Method::cppo_pid(), &spec, &backend, 0)?; // copq_candle::Candle::default()
/// assert_eq!(learner.multipliers(), [0.0]);
///
/// // A task without a cost has no limit to enforce.
/// let free = EnvSpec::new("cart", 2, 1).reward("progress", 1.0);
/// assert!(Learner::new(Method::cppo_pid(), &free, &backend, 0).is_err());
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Learner {
    pub(super) config: Config,
    pub(super) seed: u64,
    pub(super) name: String,
    pub(super) spec: EnvSpec,
    pub(super) objectives: Vec<String>,
    /// The costs' positions among them, and their limits.
    pub(super) costs: Vec<usize>,
    pub(super) limits: Vec<f64>,
    pub(super) policy: Box<dyn GaussianPolicy>,
    /// The reward's, then those of the costs that multipliers weight.
    pub(super) critics: Vec<Box<dyn StateValue>>,
    pub(super) multipliers: Vec<Multiplier>,
    pub(super) normaliser: Option<Normaliser>,
    pub(super) epoch: Epoch,
    /// The state of each environment's episode.
    pub(super) envs: Vec<EnvState>,
    /// The one that calls are about now.
    pub(super) env: usize,
    /// The undiscounted costs of the last finished episodes.
    pub(super) window: VecDeque<Vec<f64>>,
    /// Those of this epoch alone.
    pub(super) fresh: Fresh,
    /// Random numbers for the actions' noise, and for the minibatches' order.
    pub(super) noise: Rng,
    pub(super) order: Rng,
    /// Environment steps and epochs done.
    pub(super) steps: u64,
    pub(super) epochs: u64,
    pub(super) scales: Scales,
    /// One observation as the networks see it, an action's deviations, and a step's signals.
    pub(super) obs: Vec<f32>,
    pub(super) deviations: Deviations,
    pub(super) signals: Vec<f32>,
}

impl fmt::Debug for Learner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Learner")
            .field("name", &self.name)
            .field("config", &self.config)
            .field("multipliers", &self.multipliers)
            .field("steps", &self.steps)
            .field("epochs", &self.epochs)
            .finish_non_exhaustive()
    }
}

impl Learner {
    /// Makes a learner for a method and a task, with networks from a backend. Every random number
    /// comes from `seed`.
    ///
    /// An error for a task without costs if the method constrains them, and for one that does not
    /// show its budgets if the method needs them ([`Saute`](super::Saute)).
    pub fn new(method: Method, spec: &EnvSpec, backend: &dyn Backend, seed: u64) -> Result<Self> {
        let Method { name, config, .. } = method;
        config.check()?;
        spec.check()?;
        check_task(&name, &config, spec)?;
        let costs = spec.costs();
        let held = held(&config, spec);
        memory::check_on_policy(&config, spec, held + 1)?;
        let rng = &mut Rng::new(seed, Stream::Init);
        let policy = backend.policy(spec, &config.networks, rng)?;
        check_policy(&name, &config, policy.as_ref())?;
        let critics = (0..=held).map(|_| backend.value(spec, &config.networks, rng));
        let critics = critics.collect::<Result<_>>()?;
        let constraints = config.constraint.iter().cycle().take(held);
        let multipliers = constraints.map(|&rule| Multiplier::new(rule)).collect::<Result<_>>()?;
        let lengths = [spec.obs_len, spec.action_len()];
        Ok(Self {
            normaliser: normaliser(&config, spec),
            epoch: Epoch::new(config.steps_per_epoch, 1, lengths, held + 1),
            envs: vec![EnvState::new(spec, costs.len(), held + 1)],
            env: 0,
            window: VecDeque::new(),
            fresh: Fresh::new(costs.len()),
            noise: Rng::new(seed, Stream::Explore),
            order: Rng::new(seed, Stream::Batch),
            steps: 0,
            epochs: 0,
            scales: Scales::new(spec),
            obs: Vec::new(),
            deviations: Deviations::default(),
            signals: Vec::with_capacity(held + 1),
            objectives: spec.names().into_iter().map(str::to_owned).collect(),
            limits: costs.iter().filter_map(|&cost| spec.limit(cost)).map(f64::from).collect(),
            costs,
            spec: spec.clone(),
            name,
            seed,
            config,
            policy,
            critics,
            multipliers,
        })
    }

    /// The costs' multipliers, in priority order; empty if the method has none.
    pub fn multipliers(&self) -> Vec<f64> {
        self.multipliers.iter().map(Multiplier::value).collect()
    }

    /// Epochs done so far.
    pub fn epochs(&self) -> u64 {
        self.epochs
    }

    /// Writes the policy to a small file: [`Policy::read`](crate::Policy::read) reads it back.
    pub fn save_policy(&self, path: impl AsRef<std::path::Path>) -> Result<()> {
        exported(self.policy.as_ref(), self.normaliser.as_ref(), &self.about())?.write_file(path)
    }

    /// Starts with the weights and the normaliser of a policy that [`Learner::save_policy`] wrote,
    /// given the content of its file ([`State::read_file`]). The policy may be of a different
    /// method or task of the same robot.
    pub fn start_from(&mut self, policy: &State) -> Result<()> {
        let about = self.about();
        begin_with(policy, &about, self.policy.as_mut(), &mut self.normaliser)
    }

    /// The description in its policy's file.
    fn about(&self) -> About {
        About::new(&self.spec, &self.config.networks, ActorKind::Normal, Some(&self.name))
    }

    /// Divides an epoch's steps among `envs` environments.
    pub(super) fn spread(&mut self, envs: usize) -> Result<()> {
        let steps = self.config.steps_per_epoch;
        if envs == 0 || !steps.is_multiple_of(envs) {
            let wanted = format!("a divisor of steps_per_epoch, {steps}");
            return Err(Error::invalid("environments", wanted, envs));
        }
        let signals = self.critics.len();
        let lengths = [self.spec.obs_len, self.spec.action_len()];
        self.epoch = Epoch::new(steps, envs, lengths, signals);
        self.envs = vec![EnvState::new(&self.spec, self.costs.len(), signals); envs];
        Ok(())
    }
}

/// The number of costs that have critics and multipliers.
fn held(config: &Config, spec: &EnvSpec) -> usize {
    if config.constraint.is_some() { spec.costs().len() } else { 0 }
}

/// An error for a policy that cannot take a method's step.
fn check_policy(name: &str, config: &Config, policy: &dyn GaussianPolicy) -> Result<()> {
    if config.natural.is_none() || policy.parameters() > 0 {
        return Ok(());
    }
    let wanted = "a policy that writes its gradient (GaussianPolicy::parameters and the methods \
                  after it)";
    Err(Error::invalid(format!("{name}'s natural step"), wanted, "one that does not"))
}

/// The normaliser of what a method's networks see; budgets stay as they are.
fn normaliser(config: &Config, spec: &EnvSpec) -> Option<Normaliser> {
    let budgets = if config.saute.is_some() { spec.costs().len() } else { 0 };
    config.normalise.then(|| Normaliser::new(spec.obs_len - budgets).and_raw(budgets))
}

/// An error for a task that a method cannot learn.
fn check_task(name: &str, config: &Config, spec: &EnvSpec) -> Result<()> {
    if config.constraint.is_some() {
        spec.check_has_cost(name)?;
    }
    if config.saute.is_some() != shows_budgets(spec) {
        let wanted = if config.saute.is_some() {
            "an environment that shows its budgets (on_policy::Saute)"
        } else {
            "an environment without budgets, which are for settings with saute"
        };
        let what = format!("{name}'s environment");
        return Err(Error::invalid(what, wanted, format!("'{}'", spec.name)));
    }
    if spec.objectives.iter().all(|objective| objective.is_cost()) {
        let what = format!("rewards of '{}'", spec.name);
        return Err(Error::invalid(what, "at least one", "only costs"));
    }
    Ok(())
}
