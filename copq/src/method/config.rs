//! Settings of a learner, grouped like the tables of the paper.

use serde::{Deserialize, Serialize};

use super::Networks;
use crate::error::{check_count, check_fraction, check_not_negative};
use crate::projection::by_name;
use crate::{ActorKind, Constraint, Entropy, Error, FamoConfig, Result};

/// Which actions fill the replay before the first update.
///
/// ```
/// use copq::{Method, WarmUp};
///
/// let paper = Method::cop_td3_paper();
/// assert_eq!((paper.config.start_steps, paper.config.warm_up), (16_384, WarmUp::Policy));
/// let shorter = paper.warm_up(1_000);
/// assert_eq!((shorter.config.start_steps, shorter.config.warm_up), (1_000, WarmUp::Uniform));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum WarmUp {
    /// Uniform actions, as in the code of TD3's and SAC's authors.
    #[default]
    Uniform,
    /// The untrained policy's actions, with its Gaussian noise or its own samples (paper Alg. 1,
    /// which has only one rule).
    Policy,
}

/// Clipped Gaussian noise on the target policy's actions (TD3).
///
/// ```
/// use copq::{Method, Smoothing};
///
/// let mut method = Method::td3();
/// assert_eq!(method.config.smoothing, Some(Smoothing { std: 0.2, clip: 0.5 }));
/// method.config.smoothing = None; // targets from the bare policy, as in DDPG
/// assert!(method.config.check().is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Smoothing {
    /// Standard deviation, in units of half the action range.
    pub std: f64,
    /// Bound on the noise's size, in the same units.
    pub clip: f64,
}

impl Smoothing {
    /// Adds normal noise to actions in [-1, 1].
    pub(crate) fn add(self, noise: &[f32], action: &mut [f32]) {
        let (std, clip) = (self.std as f32, self.clip as f32);
        for (action, noise) in action.iter_mut().zip(noise) {
            *action = (*action + (std * *noise).clamp(-clip, clip)).clamp(-1.0, 1.0);
        }
    }
}

impl Default for Smoothing {
    /// 0.2, clipped at 0.5 (TD3; paper Table D.3).
    fn default() -> Self {
        Self { std: 0.2, clip: 0.5 }
    }
}

/// Optimistic exploration: the policy's mean moves up the gradient of the critics' upper bound
/// (OAC, paper eq. 15 and App. D.1).
///
/// ```
/// use copq::projection::step_length;
/// use copq::{Method, Optimism};
///
/// // The ellipsoid with 99 % of a normal distribution in three dimensions; the shift fades out.
/// let beta = step_length(0.99, 3)?;
/// let optimism = Optimism { beta, until: Some(50_000), ..Optimism::by("extremum") };
/// let method = Method::cop_td3_paper().explore(optimism);
/// method.config.check()?;
/// assert!((beta - 3.3682).abs() < 1e-4);
///
/// // A KL bound of 23.53 lets the mean move by the square root of twice that.
/// assert!((Optimism::default().shift - (2.0_f64 * 23.53).sqrt()).abs() < 1e-3);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Optimism {
    /// Length of the upper bound's step, the square root of chi2_N(p).
    pub beta: f64,
    /// How far the mean moves, in standard deviations of the policy: sqrt(2 delta), where delta is
    /// the KL bound. A deterministic policy's standard deviation is [`Config::exploration_std`].
    /// The default moves the mean by 0.686 at the paper's 0.1, and by 2.06 at 0.3, which is most of
    /// what [-1, 1] has room for.
    pub shift: f64,
    /// The name in [`by_name`](crate::projection::by_name) of the projection whose upper bound is
    /// used; `None` for the method's own.
    pub projection: Option<String>,
    /// Environment steps over which the shift falls linearly to 0; `None` if it never falls. The
    /// shift has its full length however little the critics disagree. Without an end, the data
    /// therefore hardly ever contains what the policy itself would do.
    pub until: Option<u64>,
}

impl Default for Optimism {
    /// A step of 4.66, and a shift of 6.86 for a KL bound of 23.53 (paper Table D.2), for the whole
    /// run.
    fn default() -> Self {
        Self { beta: 4.66, shift: 6.86, projection: None, until: None }
    }
}

impl Optimism {
    /// The defaults, with the upper bound of the named projection.
    pub fn by(projection: &str) -> Self {
        Self { projection: Some(projection.to_owned()), ..Self::default() }
    }

    /// The shift's length after `step` environment steps.
    pub(crate) fn shift_at(&self, step: u64) -> f64 {
        match self.until {
            None => self.shift,
            Some(until) if step >= until => 0.0,
            Some(until) => self.shift * (1.0 - step as f64 / until as f64),
        }
    }

    /// An error unless both lengths are finite and not negative, and the projection is known.
    pub fn check(&self) -> Result<()> {
        check_not_negative("optimism.beta", self.beta)?;
        check_not_negative("optimism.shift", self.shift)?;
        self.projection.as_deref().map_or(Ok(()), |name| by_name(name).map(drop))
    }
}

/// The settings of a [`Method`](crate::Method): what a [`Learner`](crate::Learner) does in an
/// update, how it explores, and the shape of its networks. A run's `config.toml` lists them all.
///
/// ```
/// use copq::{Config, Method};
///
/// let mut method = Method::cop_td3();
/// method.config.batch = 512;
/// method.config.networks.hidden = vec![128, 128];
/// method.config.check()?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default = "bare", deny_unknown_fields)]
pub struct Config {
    /// gamma, the discount.
    pub discount: f64,
    /// tau, the share of the online network in a Polyak step.
    pub tau: f64,
    /// Transitions in a batch.
    pub batch: usize,
    /// Transitions that the replay buffer holds.
    #[doc(alias = "buffer_size")]
    pub capacity: usize,
    /// Environment steps before the first update.
    #[doc(alias = "learning_starts")]
    pub start_steps: u64,
    /// Which actions those steps take.
    pub warm_up: WarmUp,
    /// Whether networks see observations normalised by their running mean and deviation
    /// ([`Normaliser`](crate::Normaliser)); the replay holds raw ones. An observation counts once
    /// it is stored, after the action that it led to.
    pub normalise: bool,
    /// Updates for each environment step (the update-to-data ratio).
    #[doc(alias = "utd_ratio")]
    pub updates_per_step: usize,
    /// Critic updates for each actor update.
    #[doc(alias = "policy_delay")]
    pub actor_delay: u64,
    /// Critic updates for each Polyak step of the targets.
    #[doc(alias = "target_update_interval")]
    pub target_period: u64,
    /// kappa, the length of the pessimistic step in targets and cost estimates: 1, as in the paper,
    /// goes the whole way from the critics' mean to the projection's lower bound.
    pub pessimism: f64,
    /// kappa of the actor's objective; 0 makes it the critics' mean.
    pub actor_pessimism: f64,
    /// How many critics make a target, drawn anew for every update (REDQ); `None` for all.
    pub subset: Option<usize>,
    /// Whether every critic of a cost learns from its own target network (CAL), instead of from the
    /// bound that all share.
    pub own_cost_targets: bool,
    /// Noise on target actions, if any.
    #[doc(alias = "target_policy_noise")]
    pub smoothing: Option<Smoothing>,
    /// The entropy bonus of a stochastic policy, if any.
    pub entropy: Option<Entropy>,
    /// How the limits of costs are enforced, if they are.
    pub constraint: Option<Constraint>,
    /// Balancing of the losses of objectives that share networks, if any; see
    /// [`FamoConfig::separate`] for those that do not.
    pub famo: Option<FamoConfig>,
    /// Standard deviation of the default Gaussian exploration, in units of half the action range.
    pub exploration_std: f64,
    /// Exploration towards an upper bound of the critics; `None` for the policy's noise alone.
    pub optimism: Option<Optimism>,
    /// Network shapes and step sizes.
    pub networks: Networks,
}

/// The values of settings that a stored file does not have: off where possible, or else what all
/// methods had before the setting existed.
fn bare() -> Config {
    Config {
        start_steps: 25_000,
        warm_up: WarmUp::Uniform,
        smoothing: None,
        famo: None,
        ..crate::Method::cop_td3_paper().config
    }
}

impl Config {
    /// The kind of policy that learns with these settings: a stochastic one if there is an entropy
    /// bonus.
    pub fn actor(&self) -> ActorKind {
        if self.entropy.is_some() { ActorKind::Gaussian } else { ActorKind::Deterministic }
    }

    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        check_fraction("discount", self.discount)?;
        check_fraction("tau", self.tau)?;
        for (name, count) in [
            ("batch", self.batch),
            ("capacity", self.capacity),
            ("updates_per_step", self.updates_per_step),
            ("actor_delay", self.actor_delay as usize),
            ("target_period", self.target_period as usize),
            ("start_steps", self.start_steps as usize),
        ] {
            check_count(name, count)?;
        }
        if self.subset == Some(0) {
            return Err(Error::invalid("subset", "at least 1 critic", 0));
        }
        if self.subset.is_some() && self.own_cost_targets {
            return Err(Error::invalid(
                "subset",
                "none with own_cost_targets, which needs every critic",
                "both",
            ));
        }
        check_not_negative("pessimism", self.pessimism)?;
        check_not_negative("actor_pessimism", self.actor_pessimism)?;
        check_not_negative("exploration_std", self.exploration_std)?;
        self.optimism.as_ref().map_or(Ok(()), Optimism::check)?;
        if self.smoothing.is_some() && self.entropy.is_some() {
            let wanted = "none with entropy, whose log-probability is of the unsmoothed action";
            return Err(Error::invalid("smoothing", wanted, "both"));
        }
        if let Some(smoothing) = self.smoothing {
            check_not_negative("smoothing.std", smoothing.std)?;
            check_not_negative("smoothing.clip", smoothing.clip)?;
        }
        self.famo.as_ref().map_or(Ok(()), FamoConfig::check)?;
        self.entropy.as_ref().map_or(Ok(()), Entropy::check)?;
        self.constraint.as_ref().map_or(Ok(()), Constraint::check)?;
        self.networks.check()
    }
}
