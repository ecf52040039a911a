//! The one on-policy learner: every method is a [`Method`] given to it.

use std::collections::VecDeque;
use std::fmt;

use super::episodes::{Fresh, World};
use super::epoch::Epoch;
use super::multiplier::Multiplier;
use super::normal::{Deviations, mean_entropy};
use super::saute::{costs, shows_budgets};
use super::{Config, Method, Policy, Report, SauteConfig, Value, update};
use crate::memory;
use crate::policy::{About, begin_with, exported};
use crate::{ActorKind, Backend, EnvSpec, Error, Normaliser, Observer, Result, Rng, State, Stream};

/// Learns a policy, and the values of its observations, from epochs of its own steps.
///
/// It is an [`Agent`](crate::Agent): [`Trainer`](crate::Trainer) drives it, run folders save it in
/// mid-epoch, and it goes on bit for bit. An epoch begins with a new episode; the one that it cuts
/// short counts for nothing but its steps.
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
/// // A task without a cost has nothing to hold.
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
    /// The costs' positions among them.
    pub(super) costs: Vec<usize>,
    pub(super) policy: Box<dyn Policy>,
    /// The reward's, then those of the costs that multipliers weigh.
    pub(super) critics: Vec<Box<dyn Value>>,
    pub(super) multipliers: Vec<Multiplier>,
    pub(super) normaliser: Option<Normaliser>,
    pub(super) epoch: Epoch,
    /// Where each world is.
    pub(super) worlds: Vec<World>,
    /// The one that is being talked about.
    pub(super) world: usize,
    /// The undiscounted costs of the last finished episodes.
    pub(super) window: VecDeque<Vec<f64>>,
    /// Those of this epoch alone.
    pub(super) fresh: Fresh,
    pub(super) explore: Rng,
    pub(super) order: Rng,
    /// Environment steps and epochs done.
    pub(super) steps: u64,
    pub(super) epochs: u64,
    pub(super) report: Report,
    /// One observation as the networks see it, an action's noise, its deviations, and what came of
    /// it.
    pub(super) obs: Vec<f32>,
    pub(super) noise: Vec<f32>,
    deviations: Deviations,
    signals: Vec<f32>,
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
    /// A learner by a method, for a task, with networks from a backend; every random number comes
    /// from `seed`.
    ///
    /// An error for a task without costs where a method holds them, and for one whose budgets are
    /// not in sight where a method needs them ([`Saute`](super::Saute)).
    pub fn new(method: Method, spec: &EnvSpec, backend: &dyn Backend, seed: u64) -> Result<Self> {
        let Method { name, config, .. } = method;
        config.check()?;
        spec.check()?;
        check_task(&name, &config, spec)?;
        let costs = costs(spec);
        let held = if config.constraint.is_some() { costs.len() } else { 0 };
        memory::check_on_policy(&config, spec, held + 1)?;
        let rng = &mut Rng::new(seed, Stream::Init);
        let networks = &config.networks;
        let policy = backend.policy(spec, networks, rng)?;
        if config.natural.is_some() && policy.parameters() == 0 {
            let wanted = "a policy that writes its gradient (Policy::parameters and what follows)";
            return Err(Error::invalid(format!("{name}'s natural step"), wanted, "one without"));
        }
        let critics =
            (0..=held).map(|_| backend.value(spec, networks, rng)).collect::<Result<_>>()?;
        let constraints = config.constraint.iter().cycle().take(held);
        let multipliers = constraints.map(|&rule| Multiplier::new(rule)).collect::<Result<_>>()?;
        let action = spec.action_len();
        let unseen = if config.saute.is_some() { costs.len() } else { 0 };
        Ok(Self {
            normaliser: config
                .normalise
                .then(|| Normaliser::new(spec.obs_len - unseen).and_raw(unseen)),
            epoch: Epoch::new(config.steps_per_epoch, 1, [spec.obs_len, action], held + 1),
            worlds: vec![World::new(spec, costs.len(), held + 1)],
            world: 0,
            window: VecDeque::new(),
            fresh: Fresh::new(costs.len()),
            explore: Rng::new(seed, Stream::Explore),
            order: Rng::new(seed, Stream::Batch),
            steps: 0,
            epochs: 0,
            report: Report::default(),
            obs: Vec::new(),
            noise: vec![0.0; action],
            deviations: Deviations::default(),
            signals: Vec::with_capacity(held + 1),
            objectives: spec.names().into_iter().map(str::to_owned).collect(),
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

    /// The costs' multipliers, by priority; none if nothing weighs them.
    pub fn multipliers(&self) -> Vec<f64> {
        self.multipliers.iter().map(Multiplier::value).collect()
    }

    /// Epochs done so far.
    pub fn epochs(&self) -> u64 {
        self.epochs
    }

    /// What the last epoch's learning did.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Writes the policy to a small file: [`Policy::read`](crate::Policy::read) reads it back.
    pub fn save_policy(&self, path: impl AsRef<std::path::Path>) -> Result<()> {
        exported(self.policy.as_ref(), self.normaliser.as_ref(), &self.about())?.write_file(path)
    }

    /// Begins with the policy in the content of a file that [`Learner::save_policy`] wrote
    /// ([`State::read_file`]), of this or another method and task of the
    /// same robot: its weights and its normaliser.
    pub fn start_from(&mut self, policy: &State) -> Result<()> {
        let about = self.about();
        begin_with(policy, &about, self.policy.as_mut(), &mut self.normaliser)
    }

    /// What its policy's file says.
    fn about(&self) -> About {
        About::new(&self.spec, &self.config.networks, ActorKind::Normal, Some(&self.name))
    }

    /// Shares an epoch's steps among so many worlds.
    pub(super) fn spread(&mut self, worlds: usize) -> Result<()> {
        let steps = self.config.steps_per_epoch;
        if worlds == 0 || !steps.is_multiple_of(worlds) {
            let wanted = format!("a number that steps_per_epoch, {steps}, is a multiple of");
            return Err(Error::invalid("worlds", wanted, worlds));
        }
        let signals = self.critics.len();
        let lengths = [self.spec.obs_len, self.spec.action_len()];
        self.epoch = Epoch::new(steps, worlds, lengths, signals);
        self.worlds = vec![World::new(&self.spec, self.costs.len(), signals); worlds];
        Ok(())
    }

    /// Chooses a world's action by its noise: the sample, as it is stored, and clamped to [-1, 1].
    pub(super) fn take(&mut self, noise: &[f32], action: &mut [f32]) -> Result<()> {
        let taken = &mut self.worlds[self.world].taken;
        values(&mut self.critics, &taken.obs, &mut taken.values)?;
        self.deviations.set(self.policy.log_std());
        self.policy.means(&taken.obs, action)?;
        let means = taken.action.iter_mut().zip(&*action);
        for ((sample, mean), (noise, inverse)) in
            means.zip(noise.iter().zip(self.deviations.inverse()))
        {
            *sample = (f64::from(*mean) + f64::from(*noise) / inverse) as f32;
        }
        taken.log_prob = self.deviations.log_prob(action, &taken.action);
        for (action, sample) in action.iter_mut().zip(&taken.action) {
            *action = sample.clamp(-1.0, 1.0);
        }
        Ok(())
    }

    /// What the critics expect of an observation that the networks have not seen, which counts for
    /// the normaliser.
    pub(super) fn values_of_next(&mut self, obs: &[f32]) -> Result<Vec<f32>> {
        self.take_in(obs)?;
        self.values_of_kept()
    }

    /// What the critics expect of the observation that was kept last.
    pub(super) fn values_of_kept(&mut self) -> Result<Vec<f32>> {
        let mut expected = vec![0.0; self.critics.len()];
        values(&mut self.critics, &self.obs, &mut expected)?;
        Ok(expected)
    }

    /// Lets the normaliser see an observation, and keeps it as the networks see it then.
    pub(super) fn take_in(&mut self, obs: &[f32]) -> Result<()> {
        if let Some(normaliser) = &mut self.normaliser {
            normaliser.push(obs)?;
        }
        self.keep(obs)
    }

    /// Keeps an observation as the networks see it.
    pub(super) fn keep(&mut self, obs: &[f32]) -> Result<()> {
        self.obs.clear();
        self.obs.extend_from_slice(obs);
        self.normaliser.as_ref().map_or(Ok(()), |normaliser| normaliser.normalise(&mut self.obs))
    }

    /// Adds a step to the epoch with its signals: the weighed reward, or what a spent budget makes
    /// of it, then the costs that multipliers weigh.
    pub(super) fn push(&mut self, reward: &[f32], next_obs: &[f32]) {
        // A world that shows its budgets has them last.
        let is_spent =
            |_: &SauteConfig| next_obs.iter().rev().take(self.costs.len()).any(|&left| left <= 0.0);
        let spent = self.config.saute.filter(is_spent);
        let objectives = self.spec.objectives.iter().zip(reward);
        let weighed = objectives.filter(|(objective, _)| objective.limit.is_none());
        let total: f64 = weighed.map(|(o, &reward)| f64::from(o.weight) * f64::from(reward)).sum();
        let earned = spent.map_or(total, |saute| saute.unsafe_reward);
        self.signals.clear();
        self.signals.push(earned as f32);
        self.signals.extend(self.costs.iter().take(self.multipliers.len()).map(|&i| reward[i]));
        self.epoch.push(self.world, &self.worlds[self.world].taken, &self.signals);
    }

    /// The mean costs of the last finished episodes; none if there are none.
    pub(super) fn mean_costs(&self) -> Option<Vec<f64>> {
        // The newest first, as ever: the order of a sum is part of its bits.
        let mut last = Fresh::new(self.costs.len());
        self.window.iter().rev().take(self.config.window).for_each(|costs| last.add(costs));
        last.mean()
    }

    /// A finished epoch's learning: multipliers, advantages, steps.
    pub(super) fn learn(&mut self, log: &mut dyn Observer) -> Result<()> {
        self.warn_of_short_paths(log);
        if let Some(mean) = self.mean_costs() {
            for ((multiplier, &objective), cost) in
                self.multipliers.iter_mut().zip(&self.costs).zip(mean)
            {
                let limit = self.spec.limit(objective).unwrap_or(f32::INFINITY);
                multiplier.update(cost, f64::from(limit));
            }
        }
        let Self { epoch, config, policy, critics, order, .. } = self;
        let multipliers: Vec<_> = self.multipliers.iter().map(Multiplier::value).collect();
        let rows = epoch.finish(config.discount, config.gae);
        self.report = update(
            config,
            rows,
            &multipliers,
            config.actor_lr(self.epochs),
            policy.as_mut(),
            critics,
            &mut |rows| shuffle(order, rows),
        )?;
        self.check_finite()?;
        self.log(log);
        self.epoch.clear();
        self.epochs += 1;
        self.fresh = Fresh::new(self.costs.len());
        Ok(())
    }

    /// Multipliers see finished episodes alone, and an epoch begins with new ones.
    fn warn_of_short_paths(&self, log: &mut dyn Observer) {
        let steps = self.config.steps_per_epoch / self.worlds.len();
        if self.epochs > 0 || self.multipliers.is_empty() || steps >= self.spec.horizon {
            return;
        }
        let text = format!(
            "each of {} worlds has {steps} steps an epoch, and an episode of '{}' may take {}: costs \
             of longer ones are never seen; raise steps_per_epoch or take fewer worlds",
            self.worlds.len(),
            self.spec.name,
            self.spec.horizon
        );
        log.warn(self.steps, &text);
    }

    fn check_finite(&self) -> Result<()> {
        let kl = self.report.kl.iter().chain(&self.report.second_kl);
        let losses = &self.report.critic_losses;
        if kl.chain(losses).all(|x| x.is_finite()) {
            return Ok(());
        }
        let wanted = "finite numbers (lower step sizes, or rewards near 1)";
        let what = format!("divergence and losses of epoch {}", self.epochs);
        Err(Error::invalid(what, wanted, format!("{:?}", self.report)))
    }

    fn log(&self, log: &mut dyn Observer) {
        let step = self.steps;
        let report = &self.report;
        let mut put = |name: &str, value: f64| log.scalar(step, name, value);
        put("policy/kl", report.kl.last().copied().unwrap_or(0.0));
        put("policy/passes", report.kl.len() as f64);
        if self.config.second.is_some() {
            put("policy/second_kl", report.second_kl.last().copied().unwrap_or(0.0));
            put("policy/second_passes", report.second_kl.len() as f64);
        }
        if self.config.natural.is_none() {
            put("policy/clip_share", report.clip_share);
        }
        put("policy/entropy", mean_entropy(self.policy.log_std()));
        let stds = self.policy.log_std().iter().map(|&log| libm::exp(f64::from(log)));
        put("policy/std", stds.sum::<f64>() / self.noise.len() as f64);
        if self.config.natural.is_none() {
            put("policy/lr", self.config.actor_lr(self.epochs));
        }
        let names = std::iter::once("reward")
            .chain(self.costs.iter().map(|&cost| self.objectives[cost].as_str()));
        for (k, (name, loss)) in names.clone().zip(&report.critic_losses).enumerate() {
            put(&format!("critic_loss/{name}"), *loss);
            let [spread, explained] = self.epoch.quality(k);
            put(&format!("advantage_std/{name}"), spread);
            put(&format!("explained_variance/{name}"), explained);
        }
        for (name, lambda) in names.clone().skip(1).zip(self.multipliers()) {
            put(&format!("multiplier/{name}"), lambda);
        }
        for (kind, costs) in [("window", self.mean_costs()), ("epoch", self.fresh.mean())] {
            for (name, cost) in names.clone().skip(1).zip(costs.iter().flatten()) {
                put(&format!("cost_{kind}/{name}"), *cost);
            }
        }
    }
}

/// Writes what each critic expects of one observation.
fn values(critics: &mut [Box<dyn Value>], obs: &[f32], out: &mut [f32]) -> Result<()> {
    for (critic, value) in critics.iter_mut().zip(out.chunks_exact_mut(1)) {
        critic.values(obs, value)?;
    }
    Ok(())
}

/// An error for a task that a method cannot learn.
fn check_task(name: &str, config: &Config, spec: &EnvSpec) -> Result<()> {
    let costs = costs(spec).len();
    if config.constraint.is_some() && costs == 0 {
        let what = format!("{name} on '{}'", spec.name);
        let wanted = "a task with a cost under a limit, such as b/hopper";
        return Err(Error::invalid(what, wanted, "none"));
    }
    if config.saute.is_some() != shows_budgets(spec) {
        let wanted = if config.saute.is_some() {
            "a world that shows its budgets (on_policy::Saute)"
        } else {
            "a world without budgets, which are for settings with saute"
        };
        return Err(Error::invalid(format!("{name}'s world"), wanted, format!("'{}'", spec.name)));
    }
    if spec.objectives.len() == costs {
        let what = format!("rewards of '{}'", spec.name);
        return Err(Error::invalid(what, "one at least", "costs alone"));
    }
    Ok(())
}

/// Fisher and Yates.
fn shuffle(rng: &mut Rng, rows: &mut [usize]) {
    for i in (1..rows.len()).rev() {
        rows.swap(i, rng.below(i + 1));
    }
}
