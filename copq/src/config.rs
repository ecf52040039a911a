//! Settings of a learner, grouped like the tables of the paper, with presets.

use serde::{Deserialize, Serialize};

use crate::error::check_not_negative;
use crate::{Constraint, Entropy, Error, FamoConfig, LagrangianConfig, Projection, Result};

/// Network shapes and step sizes, for the backend that builds the networks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Networks {
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// Adam's step size for the critics.
    pub critic_lr: f64,
    /// Adam's step size for the actor.
    pub actor_lr: f64,
    /// How weights and biases are drawn.
    #[serde(default)]
    pub init: Init,
    /// The function after each hidden layer.
    #[serde(default)]
    pub activation: Activation,
}

/// The function between two layers of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// max(0, x): every off-policy method of the paper.
    #[default]
    Relu,
    /// tanh(x): on-policy methods.
    Tanh,
    /// x / (1 + exp(-x)): CAL's authors have it in their cost critics; here it is all networks'.
    Silu,
}

/// The distribution of a network's initial weights; every layer has the same rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Init {
    /// Weights and biases uniform within 1/sqrt(inputs): `torch.nn.Linear`'s, and so TD3's.
    #[default]
    Torch,
    /// Weights uniform within sqrt(3/inputs), which keeps the inputs' variance, and no biases: Brax's.
    Lecun,
}

impl Default for Networks {
    /// Two hidden layers of 256 with ReLU, step sizes 3e-4 (paper Table D.3).
    fn default() -> Self {
        Self {
            hidden: vec![256, 256],
            critic_lr: 3e-4,
            actor_lr: 3e-4,
            init: Init::Torch,
            activation: Activation::Relu,
        }
    }
}

impl Networks {
    /// An error for a setting no network can have.
    pub fn check(&self) -> Result<()> {
        if self.hidden.is_empty() || self.hidden.contains(&0) {
            return Err(Error::invalid("networks.hidden", "one or more positive widths", format!("{:?}", self.hidden)));
        }
        for (name, lr) in [("networks.critic_lr", self.critic_lr), ("networks.actor_lr", self.actor_lr)] {
            if !(lr.is_finite() && lr > 0.0) {
                return Err(Error::invalid(name, "a positive number", lr));
            }
        }
        Ok(())
    }
}

/// Whose actions fill the replay before the first update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WarmUp {
    /// Uniform actions (TD3's and SAC's authors' code).
    #[default]
    Uniform,
    /// The untrained policy's, with its Gaussian noise or its own samples (paper Alg. 1, which has but one rule).
    Policy,
}

/// Clipped Gaussian noise on the target policy's actions (TD3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Smoothing {
    /// Standard deviation, in units of half the action range.
    pub std: f64,
    /// Bound on the noise's size, in the same units.
    pub clip: f64,
}

/// Exploration towards what the critics may promise: the policy's mean moves up the gradient of their upper bound
/// (OAC, paper eq. 15 and App. D.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Optimism {
    /// Length of the upper bound's step, the root of chi2_N(p).
    pub beta: f64,
    /// How far the mean moves, in standard deviations of the policy: sqrt(2 delta), delta the KL bound.
    pub shift: f64,
    /// Whose upper bound, by its name in [`by_name`](crate::projection::by_name); the learner's own projection's unless named.
    pub projection: Option<String>,
}

impl Default for Optimism {
    /// 4.66, and 6.86 for a KL bound of 23.53 (paper Table D.2).
    fn default() -> Self {
        Self { beta: 4.66, shift: 6.86, projection: None }
    }
}

impl Optimism {
    /// An error unless both lengths are finite and not negative.
    pub fn check(&self) -> Result<()> {
        check_not_negative("optimism.beta", self.beta)?;
        check_not_negative("optimism.shift", self.shift)
    }
}

/// What a [`Learner`](crate::Learner) does in an update; the strategies it does it with (projection, exploration) are
/// given to the learner itself. N objectives, in priority order:
///
/// | method | preset | critics | projection | actor |
/// |---|---|---|---|---|
/// | COP-Q on TD3 | [`Config::cop_td3`] | N + 1 | [`Cholesky`](crate::projection::Cholesky) | deterministic |
/// | COP-Q on TD3 + COP-OAC | [`Config::cop_td3_oac`] | N + 1 | [`Cholesky`](crate::projection::Cholesky) | deterministic |
/// | the paper's main comparison | [`Config::cop_td3_paper`] | as the projection says | any | deterministic |
/// | TD3 | [`Config::td3`] | 2, for N = 1 | any | deterministic |
/// | REDQ | [`Config::cop_td3_paper`]`.redq()` | 10 | [`ScalarisedMin`](crate::projection::ScalarisedMin) | deterministic |
/// | SAC | [`Config::sac`] | 2, for N = 1 | any | stochastic |
/// | SAC-Lagrangian | [`Config::sac_lagrangian`] | [`SeparateCritics`](crate::SeparateCritics), 1 cost and 2 reward | [`IndependentMin`](crate::projection::IndependentMin) | stochastic |
/// | SACLag-UCB | [`Config::sac_lagrangian`] | [`SeparateCritics`](crate::SeparateCritics), 2 and 2 | [`IndependentMin`](crate::projection::IndependentMin) | stochastic |
/// | CAL | [`Config::cal`] | [`SeparateCritics`](crate::SeparateCritics), 4 and 2 | [`Conservative::cal`](crate::projection::Conservative::cal) | stochastic |
/// | COP-Q on CAL | [`Config::cop_cal`] | 3 | [`Cholesky`](crate::projection::Cholesky) | stochastic |
///
/// Each takes [`Config::optimism`], which makes it OAC: [`Config::cop_td3_oac`] is COP-Q on TD3 with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// gamma, the discount.
    pub discount: f64,
    /// tau, the share of the online network in a Polyak step.
    pub tau: f64,
    /// Transitions in a batch.
    pub batch: usize,
    /// Transitions that the replay buffer holds.
    pub capacity: usize,
    /// Environment steps before the first update.
    pub start_steps: u64,
    /// Whose actions those steps take.
    #[serde(default)]
    pub warm_up: WarmUp,
    /// Whether networks see observations in units of their running deviation ([`Normaliser`](crate::Normaliser)); the replay
    /// holds raw ones. An observation counts when it is stored, after the action that it led to.
    #[serde(default)]
    pub normalise: bool,
    /// Updates for each environment step (the update-to-data ratio).
    pub updates_per_step: usize,
    /// Critic updates for each actor update.
    pub actor_delay: u64,
    /// Critic updates for each Polyak step of the targets.
    pub target_period: u64,
    /// kappa, the length of the pessimistic step in targets and cost estimates: the bound is mean - kappa C R u.
    pub pessimism: f64,
    /// kappa of the actor's objective; 0 makes it the critics' mean.
    pub actor_pessimism: f64,
    /// Critics that make a target, drawn anew for every update (REDQ); all unless given.
    pub subset: Option<usize>,
    /// Whether every critic of a cost learns from its own target network (CAL), not from the bound that all share.
    pub own_cost_targets: bool,
    /// Noise on target actions, if any.
    pub smoothing: Option<Smoothing>,
    /// The entropy bonus of a stochastic policy, if any.
    pub entropy: Option<Entropy>,
    /// How the limits of costs are held, if they are.
    pub constraint: Option<Constraint>,
    /// Balancing of the losses of objectives that share networks, if any; not for [`SeparateCritics`](crate::SeparateCritics).
    pub famo: Option<FamoConfig>,
    /// Standard deviation of the default Gaussian exploration, in units of half the action range.
    pub exploration_std: f64,
    /// Exploration towards an upper bound of the critics; the policy and its noise alone without.
    pub optimism: Option<Optimism>,
    /// Network shapes and step sizes.
    pub networks: Networks,
}

impl Config {
    /// COP-Q on TD3 as we use it: the preset to begin with. It is [`Config::cop_td3_paper`] but for five settings, chosen by
    /// single runs on a hopper, which do not yet show what each is worth (DESIGN.md has them):
    ///
    /// * a warm-up of 1,000 uniform actions, since a hopper that acts at random falls after 20 steps;
    /// * exploration noise of 0.3;
    /// * observations in units of their deviation;
    /// * initial weights that keep the inputs' variance, and no biases;
    /// * no FAMO, which can starve an objective.
    pub fn cop_td3() -> Self {
        Self {
            start_steps: 1_000,
            warm_up: WarmUp::Uniform,
            exploration_std: 0.3,
            normalise: true,
            networks: Networks { init: Init::Lecun, ..Networks::default() },
            famo: None,
            ..Self::cop_td3_paper()
        }
    }

    /// COP-Q on TD3 that explores towards the critics' upper bound (COP-OAC, paper sec. 5.2 and Table D.2): by the
    /// learner's own projection, unless [`Optimism::projection`] names another. The rest is [`Config::cop_td3_paper`] after
    /// a warm-up of 1,000 uniform actions.
    pub fn cop_td3_oac() -> Self {
        Self {
            start_steps: 1_000,
            warm_up: WarmUp::Uniform,
            optimism: Some(Optimism::default()),
            ..Self::cop_td3_paper()
        }
    }

    /// COP-Q on TD3 in the protocol of the paper's main comparison (sec. 5.1), for reproduction. Where the paper gives no
    /// number, its authors' later code does.
    ///
    /// | setting | value | source |
    /// |---|---|---|
    /// | discount, tau, batch, capacity, step sizes, hidden layers | 0.99, 0.005, 256, 1e6, 3e-4, 256 x 256 ReLU | Table D.3 |
    /// | updates a step, actor delay, target period | 1, 2, 1 | Table D.3 |
    /// | exploration | Gaussian noise of 0.1 alone | sec. 5, 5.1, Table D.3 |
    /// | target smoothing | 0.2, clipped at 0.5 | Table D.3 |
    /// | warm-up | 16,384 steps of the untrained policy with its noise | App. D (more than 10,000); the authors' code; Alg. 1 |
    /// | FAMO, whatever the projection | AdamW 0.025, 0.001 | sec. 5, Table D.1 |
    /// | pessimism in targets and actor | 1 | eqs. 11, 13, 14 |
    /// | observations, initial weights | raw, PyTorch's | the paper gives none |
    ///
    /// The paper's other methods differ in projection and critics alone: N + 1 critics for
    /// [`Extremum`](crate::projection::Extremum), 2 for [`ScalarisedMin`](crate::projection::ScalarisedMin), 2 separate
    /// ones an objective for [`IndependentMin`](crate::projection::IndependentMin). It is meant without
    /// [`Config::for_projection`], which would take FAMO away from separate critics.
    pub fn cop_td3_paper() -> Self {
        Self {
            discount: 0.99,
            tau: 0.005,
            batch: 256,
            capacity: 1_000_000,
            start_steps: 16_384,
            warm_up: WarmUp::Policy,
            normalise: false,
            updates_per_step: 1,
            actor_delay: 2,
            target_period: 1,
            pessimism: 1.0,
            actor_pessimism: 1.0,
            subset: None,
            own_cost_targets: false,
            entropy: None,
            constraint: None,
            smoothing: Some(Smoothing { std: 0.2, clip: 0.5 }),
            famo: Some(FamoConfig::default()),
            exploration_std: 0.1,
            optimism: None,
            networks: Networks::default(),
        }
    }

    /// TD3 as its authors have it (Fujimoto et al. 2018): noise alone explores, targets follow at every second update, the
    /// warm-up is 25,000 steps. Meant for one objective and 2 critics, with which every projection is its clipped
    /// double-Q; the actor climbs the smaller critic, too, where theirs climbs the first.
    pub fn td3() -> Self {
        Self { start_steps: 25_000, warm_up: WarmUp::Uniform, target_period: 2, famo: None, ..Self::cop_td3_paper() }
    }

    /// Randomised ensembled double-Q (REDQ): 20 updates an environment step, the 20th with the actor's; each target
    /// from 2 critics drawn at random by [`ScalarisedMin`](crate::projection::ScalarisedMin), the actor on the mean of
    /// all. Meant for 10 critics, exploration by noise alone, a warm-up of 5,000 steps (Chen et al. 2021; paper sec. 5.1
    /// and App. D).
    pub fn redq(self) -> Self {
        Self {
            capacity: 100_000,
            start_steps: 5_000,
            warm_up: WarmUp::Uniform,
            updates_per_step: 20,
            actor_delay: 20,
            target_period: 1,
            actor_pessimism: 0.0,
            subset: Some(2),
            ..self
        }
    }

    /// SAC with a learned temperature: the constants of the paper's Table D.3, a warm-up of 10,000 steps; actor, temperature
    /// and targets move at every second update. With one objective and 2 critics every projection is SAC's clipped double-Q.
    pub fn sac() -> Self {
        Self {
            start_steps: 10_000,
            actor_delay: 2,
            target_period: 2,
            smoothing: None,
            entropy: Some(Entropy::default()),
            ..Self::td3()
        }
    }

    /// SAC with a Lagrange multiplier for each cost. [`IndependentMin`](crate::projection::IndependentMin) on 2 separate
    /// critics per objective makes it SACLag-UCB; on 2 for the reward and 1 for the cost, SAC-Lagrangian.
    pub fn sac_lagrangian() -> Self {
        let plain = LagrangianConfig { augmentation: 0.0, ..Default::default() };
        Self { constraint: Some(Constraint::Lagrangian(plain)), ..Self::sac() }
    }

    /// COP-Q on CAL (paper sec. 5 and Table D.3): SAC under the augmented Lagrangian, for the Cholesky projection on
    /// 3 critics of cost and reward, the cost first.
    pub fn cop_cal() -> Self {
        Self { constraint: Some(Constraint::Lagrangian(LagrangianConfig::default())), ..Self::sac() }
    }

    /// CAL as the paper compares it: [`Config::cop_cal`]'s constants, but every cost critic learns from itself. Meant for
    /// [`Conservative::cal`](crate::projection::Conservative::cal) on 4 critics of the cost and 2 of the reward.
    pub fn cal() -> Self {
        Self { own_cost_targets: true, ..Self::cop_cal() }
    }

    /// CAL with the constants of its authors' code (Wu et al. 2024): batches of 12, 10 updates a step, the actor at each.
    pub fn cal_original() -> Self {
        let lagrangian = LagrangianConfig { multiplier: std::f64::consts::LN_2, lr: 3e-4, ..Default::default() };
        Self {
            batch: 12,
            start_steps: 5_000,
            updates_per_step: 10,
            actor_delay: 1,
            entropy: Some(Entropy { lr: 3e-4, ..Default::default() }),
            constraint: Some(Constraint::Lagrangian(lagrangian)),
            ..Self::cal()
        }
    }

    /// The same for a projection's critics: without FAMO if they are separate, for it balances only the losses of objectives
    /// that share networks.
    pub fn for_projection(self, projection: &dyn Projection) -> Self {
        Self { famo: self.famo.filter(|_| !projection.separate()), ..self }
    }

    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        fraction("discount", self.discount)?;
        fraction("tau", self.tau)?;
        for (name, count) in [
            ("batch", self.batch as u64),
            ("updates_per_step", self.updates_per_step as u64),
            ("actor_delay", self.actor_delay),
            ("target_period", self.target_period),
            ("start_steps", self.start_steps),
        ] {
            if count == 0 {
                return Err(Error::invalid(name, "at least 1", 0));
            }
        }
        if self.subset == Some(0) {
            return Err(Error::invalid("subset", "at least 1 critic", 0));
        }
        if self.subset.is_some() && self.own_cost_targets {
            return Err(Error::invalid("subset", "none with own_cost_targets, which needs every critic", "both"));
        }
        check_not_negative("pessimism", self.pessimism)?;
        check_not_negative("actor_pessimism", self.actor_pessimism)?;
        check_not_negative("exploration_std", self.exploration_std)?;
        if let Some(optimism) = &self.optimism {
            optimism.check()?;
        }
        if self.smoothing.is_some() && self.entropy.is_some() {
            let wanted = "none with entropy, whose log-probability is that of the action without it";
            return Err(Error::invalid("smoothing", wanted, "both"));
        }
        if let Some(smoothing) = self.smoothing {
            check_not_negative("smoothing.std", smoothing.std)?;
            check_not_negative("smoothing.clip", smoothing.clip)?;
        }
        self.networks.check()
    }
}

fn fraction(name: &str, value: f64) -> Result<()> {
    if (0.0..=1.0).contains(&value) { Ok(()) } else { Err(Error::invalid(name, "a number from 0 to 1", value)) }
}
