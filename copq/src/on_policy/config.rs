//! The settings of an on-policy method.

use serde::{Deserialize, Serialize};

use crate::error::{check_count, check_fraction, check_not_negative};
use crate::{Activation, Error, Init, Networks, PidConfig, Result};

/// The settings of an on-policy [`Method`](super::Method): how an epoch is gathered, how the policy
/// and its critics learn from it, and how limits are enforced. A run's `config.toml` lists them
/// all.
///
/// ```
/// use copq::on_policy::Method;
///
/// let mut method = Method::cppo_pid();
/// method.config.steps_per_epoch = 4_096;
/// method.config.networks.hidden = vec![128, 128];
/// method.config.check()?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// gamma, the discount of rewards and costs.
    pub discount: f64,
    /// lambda of the generalised advantages of rewards and costs (Schulman et al. 2016).
    pub gae: f64,
    /// Environment steps per epoch, in all environments together.
    pub steps_per_epoch: usize,
    /// Environment steps over which the policy's step size falls to 0, one epoch at a time; `None`
    /// keeps it constant.
    #[serde(default)] // a stored run without it has none
    pub anneal_steps: Option<u64>,
    /// The largest number of passes over an epoch's rows.
    pub passes: usize,
    /// Rows in a minibatch.
    pub batch: usize,
    /// How far passes may move the policy: they end, the critics' included, when KL(old || new),
    /// summed over action components, is larger. As in OmniSafe, a natural step goes this far, to
    /// second order, in the mean over components. The sum, which is reported, is therefore larger.
    pub target_kl: f64,
    /// A ratio of probabilities further than this from 1 gains nothing more in the objective.
    pub clip: f64,
    /// The natural-gradient step that replaces the clipped ones, if any. It ignores `clip`,
    /// `entropy` and the policy's step size.
    pub natural: Option<NaturalStep>,
    /// A second step of the policy, down its costs, if any (CUP).
    pub second: Option<SecondStep>,
    /// Weight of the policy's entropy, averaged over action components.
    pub entropy: f64,
    /// c of the penalty c sum(p^2) in the critics' losses.
    pub critic_decay: f64,
    /// The largest norm of a network's gradient.
    pub max_norm: f64,
    /// How the multipliers of costs are set, if multipliers enforce the limits.
    pub constraint: Option<Constraint>,
    /// How many of the last finished episodes make the mean cost that the multipliers see.
    pub window: usize,
    /// Budgets in the observations, if budgets enforce the limits ([`Saute`](super::Saute)).
    pub saute: Option<SauteConfig>,
    /// Whether networks see observations normalised by their running mean and deviation
    /// ([`Normaliser`](crate::Normaliser)).
    pub normalise: bool,
    /// Network shapes and step sizes.
    pub networks: Networks,
}

/// The rule for a cost's multiplier. The multiplier weights the cost's advantages against the
/// reward's: `(A_r - sum lambda_j A_j) / (1 + sum lambda_j)`. It learns once per epoch, from the
/// mean undiscounted cost of the last finished episodes.
///
/// ```
/// use copq::on_policy::{Ascent, Constraint, Method};
///
/// let mut method = Method::ppo_lag();
/// method.config.constraint = Some(Constraint::Adam(Ascent { lr: 0.05, ..Ascent::default() }));
/// method.config.check()?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Constraint {
    /// A PID controller (Stooke et al. 2020). It learns once per epoch, and [`PidConfig::cppo_pid`]
    /// has gains for that. Settings that are left out are as in [`PidConfig::default`], whose gains
    /// are meant for learning at every update.
    Pid(PidConfig),
    /// Gradient ascent by Adam on lambda itself.
    Adam(Ascent),
}

impl Constraint {
    /// An error that names the first setting that cannot be used.
    pub(super) fn check(&self) -> Result<()> {
        let Ascent { lr, multiplier, cap } = match self {
            Self::Pid(config) => return config.check(),
            Self::Adam(ascent) => *ascent,
        };
        check_not_negative("constraint.lr", lr)?;
        if !((0.0..=cap).contains(&multiplier) && multiplier.is_finite()) {
            let wanted = format!("a finite number from 0 to the cap, {cap}");
            return Err(Error::invalid("constraint.multiplier", wanted, multiplier));
        }
        Ok(())
    }
}

/// Constants of [`Constraint::Adam`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ascent {
    /// Adam's step size: lambda moves by about this much per epoch, however large the violation.
    pub lr: f64,
    /// The initial lambda.
    pub multiplier: f64,
    /// The largest lambda; `inf` for none.
    pub cap: f64,
}

impl Default for Ascent {
    /// OmniSafe's: a step size of 0.035 and an initial lambda of 0.001, without a cap.
    fn default() -> Self {
        Self { lr: 0.035, multiplier: 0.001, cap: f64::INFINITY }
    }
}

/// Constants of the natural-gradient step (Kakade 2001), as in OmniSafe's RCPO: its Fisher matrix,
/// and so its KL, are means over rows *and* action components.
///
/// ```
/// use copq::on_policy::NaturalStep;
///
/// assert_eq!(NaturalStep::default(), NaturalStep { iterations: 15, damping: 0.1 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NaturalStep {
    /// The largest number of conjugate-gradient iterations.
    pub iterations: usize,
    /// What is added to the diagonal of the Fisher matrix.
    pub damping: f64,
}

impl Default for NaturalStep {
    /// OmniSafe's: 15 and 0.1.
    fn default() -> Self {
        Self { iterations: 15, damping: 0.1 }
    }
}

/// Constants of CUP's second step (Yang et al. 2022). It goes down the costs' advantages, weighted
/// by the multipliers, and stays close to where the first step led.
///
/// ```
/// use copq::on_policy::SecondStep;
///
/// assert_eq!(SecondStep::default().passes, 40);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SecondStep {
    /// The largest number of passes over the epoch's rows.
    pub passes: usize,
}

impl Default for SecondStep {
    /// OmniSafe's: 40.
    fn default() -> Self {
        Self { passes: 40 }
    }
}

/// Constants of [`Saute`](super::Saute) (Sootla et al. 2022).
///
/// ```
/// use copq::on_policy::SauteConfig;
///
/// // A limit of 740.2 on the costs of 1,000 steps, as a discounted budget.
/// let budget = SauteConfig::default().budget(740.2, 1_000);
/// assert!((budget - 468.03).abs() < 5e-3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SauteConfig {
    /// The discount of what is spent. The [`Saute`](super::Saute) around the environment uses it:
    /// give both it and the learner the same settings.
    pub discount: f64,
    /// The reward that the learner gives for a step after which a budget is spent.
    pub unsafe_reward: f64,
}

impl Default for SauteConfig {
    /// OmniSafe's: a discount of 0.999 and a reward of -1.
    fn default() -> Self {
        Self { discount: 0.999, unsafe_reward: -1.0 }
    }
}

impl SauteConfig {
    /// An error that names the first setting that cannot be used.
    pub(super) fn check(&self) -> Result<()> {
        if !(self.discount > 0.0 && self.discount <= 1.0) {
            let wanted = "a number above 0, at most 1";
            return Err(Error::invalid("saute.discount", wanted, self.discount));
        }
        if !self.unsafe_reward.is_finite() {
            let what = "saute.unsafe_reward";
            return Err(Error::invalid(what, "a finite number", self.unsafe_reward));
        }
        Ok(())
    }

    /// A limit on an episode's cost as a budget: the discounted value of paying it evenly over the
    /// episode.
    pub fn budget(&self, limit: f64, horizon: usize) -> f64 {
        crate::discounted_limit(limit, self.discount, horizon)
    }
}

impl Default for Config {
    /// OmniSafe's PPO for a million steps, and the values of settings that a stored file does not
    /// have.
    fn default() -> Self {
        Self {
            discount: 0.99,
            gae: 0.95,
            steps_per_epoch: 2_048,
            anneal_steps: Some(1_024_000),
            passes: 40,
            batch: 64,
            target_kl: 0.02,
            clip: 0.2,
            natural: None,
            second: None,
            entropy: 0.0,
            critic_decay: 0.001,
            max_norm: 40.0,
            constraint: None,
            window: 50,
            saute: None,
            normalise: true,
            networks: Networks {
                hidden: vec![64, 64],
                critic_lr: 3e-4,
                actor_lr: 3e-4,
                init: Init::Torch,
                activation: Activation::Tanh,
                ..Networks::default()
            },
        }
    }
}

impl Config {
    /// The policy's step size in an epoch, counted from 0: `lr (1 - k/K)` in epoch k of K, and
    /// after those as in the last one.
    pub fn actor_lr(&self, epoch: u64) -> f64 {
        let lr = self.networks.actor_lr;
        let Some(steps) = self.anneal_steps else { return lr };
        let epochs = (steps / self.steps_per_epoch as u64).max(1);
        lr * (1.0 - epoch.min(epochs - 1) as f64 / epochs as f64)
    }

    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        check_fraction("discount", self.discount)?;
        check_fraction("gae", self.gae)?;
        if self.second.is_some() && self.discount == 1.0 {
            return Err(Error::invalid("discount", "less than 1 with a second step", 1));
        }
        for (name, count) in [
            ("steps_per_epoch", self.steps_per_epoch),
            ("passes", self.passes),
            ("batch", self.batch),
            ("window", self.window),
            ("natural.iterations", self.natural.map_or(1, |natural| natural.iterations)),
            ("second.passes", self.second.map_or(1, |second| second.passes)),
        ] {
            check_count(name, count)?;
        }
        for (name, value) in [
            ("target_kl", self.target_kl),
            ("clip", self.clip),
            ("entropy", self.entropy),
            ("critic_decay", self.critic_decay),
            ("natural.damping", self.natural.map_or(0.0, |natural| natural.damping)),
        ] {
            check_not_negative(name, value)?;
        }
        if self.max_norm.is_nan() || self.max_norm <= 0.0 {
            return Err(Error::invalid("max_norm", "a positive number, or inf", self.max_norm));
        }
        if let Some(saute) = &self.saute {
            saute.check()?;
        }
        if self.second.is_some() && self.natural.is_some() {
            return Err(Error::invalid("second", "none with a natural step", "one"));
        }
        if self.anneal_steps == Some(0) {
            return Err(Error::invalid("anneal_steps", "at least 1, or none", 0));
        }
        self.constraint.as_ref().map_or(Ok(()), Constraint::check)?;
        if self.second.is_some() && self.constraint.is_none() {
            let wanted = "none without a constraint, whose multipliers weight it";
            return Err(Error::invalid("second", wanted, "one"));
        }
        self.networks.check_f32("an on-policy method")
    }
}
