//! A method is a value: its settings, the bound of its targets, and the critics that go with it.

mod config;
mod ensemble;
mod networks;
mod presets;

pub use config::{Config, Optimism, Smoothing, WarmUp};
pub use ensemble::Ensemble;
pub use networks::{Activation, Init, Networks, Precision};

use std::sync::Arc;

use crate::projection::ScalarisedMin;
use crate::{ActorKind, Constraint, FamoConfig, Projection};

/// The algorithm that a [`Learner`](crate::Learner) uses. Every off-policy method of copq is a
/// value of this type, and so is your own: take the nearest preset and change what is different.
///
/// ```
/// use copq::projection::{Cholesky, Extremum};
/// use copq::{FamoConfig, Method, Optimism};
///
/// // Swap the projection: its critics come with it.
/// let swapped = Method::cop_td3().bound(Extremum);
///
/// // COP-OAC, part by part: TD3 with a vector of values, their Cholesky bound, balanced losses
/// // and an optimistic explorer.
/// let mut method = Method::td3()
///     .bound(Cholesky)
///     .balance(FamoConfig::default())
///     .explore(Optimism::default());
/// method.config.batch = 512;
/// # let _ = swapped;
/// ```
///
/// The presets, for N objectives in priority order ([`Method::bound`] swaps bound and critics):
///
/// | method | preset | critics | bound | actor |
/// |---|---|---|---|---|
/// | COP-Q on TD3 | [`Method::cop_td3`] | N + 1 | [`Cholesky`](crate::projection::Cholesky) | deterministic |
/// | COP-Q on TD3 + COP-OAC | [`Method::cop_td3_oac`] | N + 1 | [`Cholesky`](crate::projection::Cholesky) | deterministic |
/// | the paper's main comparison | [`Method::cop_td3_paper`] | N + 1 | [`Cholesky`](crate::projection::Cholesky) | deterministic |
/// | TD3 | [`Method::td3`] | 2 | [`ScalarisedMin`] | deterministic |
/// | REDQ | [`Method::cop_td3_paper`]`.redq()` | 10 | [`ScalarisedMin`] | deterministic |
/// | SAC | [`Method::sac`] | 2 | [`ScalarisedMin`] | stochastic |
/// | SAC-Lagrangian | [`Method::sac_lagrangian`] | 1 of each cost, 2 of each reward | [`IndependentMin`](crate::projection::IndependentMin) | stochastic |
/// | SAC-PID | [`Method::sac_pid`] | 1 and 2 | [`IndependentMin`](crate::projection::IndependentMin) | stochastic |
/// | SACLag-UCB | [`Method::saclag_ucb`] | 2 and 2 | [`IndependentMin`](crate::projection::IndependentMin) | stochastic |
/// | CAL | [`Method::cal`], [`Method::cal_original`] | 4 and 2 | [`MeanStd::cal`](crate::projection::MeanStd::cal) | stochastic |
/// | COP-Q on CAL | [`Method::cop_cal`] | N + 1 | [`Cholesky`](crate::projection::Cholesky) | stochastic |
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Method {
    /// The name that command lines, run folders and checkpoints use for it.
    pub name: String,
    /// Its settings.
    pub config: Config,
    /// The projection whose lower bound of the critics' values the targets and the actor use.
    pub bound: Arc<dyn Projection>,
    /// The critics to learn with.
    pub critics: Ensemble,
    /// Where it comes from, such as a paper and its section.
    pub source: String,
}

impl Method {
    /// Your own method, with the critics that its bound is meant for.
    pub fn new(name: impl Into<String>, config: Config, bound: impl Projection + 'static) -> Self {
        let critics = bound.ensemble();
        Self { name: name.into(), config, critics, bound: Arc::new(bound), source: String::new() }
    }

    /// Swaps the bound, and the critics for those that the new bound is meant for. This removes
    /// [`Config::subset`] (REDQ) and [`Config::own_cost_targets`] (CAL), which belonged to the old
    /// critics. All other settings stay, such as the pessimism.
    pub fn bound(self, bound: impl Projection + 'static) -> Self {
        let config = Config { subset: None, own_cost_targets: false, ..self.config };
        Self { config, critics: bound.ensemble(), bound: Arc::new(bound), ..self }
    }

    /// Swaps the critics for others than those that the bound is meant for.
    pub fn critics(self, critics: Ensemble) -> Self {
        Self { critics, ..self }
    }

    /// Renames it, for command lines, run folders and checkpoints.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Balances the objectives' losses (FAMO).
    pub fn balance(mut self, famo: FamoConfig) -> Self {
        self.config.famo = Some(famo);
        self
    }

    /// Explores towards an upper bound of the critics (OAC).
    pub fn explore(mut self, optimism: Optimism) -> Self {
        self.config.optimism = Some(optimism);
        self
    }

    /// Enforces the limits of the task's costs.
    pub fn constrain(mut self, constraint: Constraint) -> Self {
        self.config.constraint = Some(constraint);
        self
    }

    /// Starts with `steps` uniform actions, before the first update.
    pub fn warm_up(mut self, steps: u64) -> Self {
        self.config.start_steps = steps;
        self.config.warm_up = WarmUp::Uniform;
        self
    }

    /// Randomised ensembled double-Q (REDQ, Chen et al. 2021; paper sec. 5.1 and App. D): 10
    /// critics and 20 updates per environment step, the 20th of which also updates the actor. Each
    /// target is the [`ScalarisedMin`] of 2 critics drawn at random, and the actor uses the mean of
    /// all critics. The warm-up is 5,000 steps.
    pub fn redq(self) -> Self {
        let name = if self.config.entropy.is_some() { "redq-sac" } else { "redq" };
        let mut redq =
            self.named(name).bound(ScalarisedMin).critics(Ensemble::Joint(10)).warm_up(5_000);
        redq.config = Config {
            capacity: 100_000,
            updates_per_step: 20,
            actor_delay: 20,
            target_period: 1,
            actor_pessimism: 0.0,
            subset: Some(2),
            ..redq.config
        };
        redq
    }

    /// The kind of policy that it learns: a stochastic one if it has an entropy bonus.
    pub fn actor(&self) -> ActorKind {
        self.config.actor()
    }
}
