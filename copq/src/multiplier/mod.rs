//! Where the scalarisation weights come from: constants, or multipliers that learn to enforce a
//! constraint.

mod costs;
mod fixed;
mod lagrangian;
mod pid;

use std::fmt::Debug;

use serde::{Deserialize, Serialize};

pub use costs::discounted_limit;
pub use fixed::FixedWeights;
pub use lagrangian::{Lagrangian, LagrangianConfig};
pub(crate) use pid::Controller;
pub use pid::{Pid, PidConfig};

use crate::{EnvSpec, Observer, Result, State};

/// The current weights of the objectives, and the rule that changes them.
///
/// At every update of the actor, the learner first passes in the costs ([`Multiplier::observe`]),
/// then improves the actor with [`Multiplier::actor_weights`], then lets the multiplier learn
/// ([`Multiplier::update`]).
///
/// ```
/// use copq::{Multiplier, Result, State};
///
/// /// Doubles the multiplier of a cost while its limit is exceeded, and halves it otherwise,
/// /// between 0.001 and 1,000. The objectives are the cost and a reward.
/// #[derive(Debug)]
/// struct Doubling {
///     limit: f32,
///     weights: [f32; 2],
///     actor_weights: [f64; 2],
/// }
///
/// impl Multiplier for Doubling {
///     fn weights(&self) -> &[f32] { &self.weights }
///     fn actor_weights(&self) -> &[f64] { &self.actor_weights }
///
///     fn observe(&mut self, bound: &[f32]) {
///         let factor = if bound[0] > self.limit { 2.0 } else { 0.5 };
///         self.weights[0] = (self.weights[0] * factor).clamp(-1000.0, -0.001);
///         self.actor_weights[0] = self.weights[0].into();
///     }
///
///     // What a run needs to resume as if it had never stopped.
///     fn save(&self, state: &mut State) {
///         state.put("cost", [self.weights[0]]);
///     }
///
///     fn load(&mut self, state: &State) -> Result<()> {
///         self.weights[0] = state.get_one("cost")?;
///         self.actor_weights[0] = self.weights[0].into();
///         Ok(())
///     }
/// }
///
/// // An episode of 1,000 steps may cost 100, and a bound is discounted. A cost's weight is negative.
/// // Learner::multiplier accepts such a value.
/// let limit = copq::discounted_limit(100.0, 0.99, 1_000) as f32;
/// let mut doubling = Doubling { limit, weights: [-1.0, 1.0], actor_weights: [-1.0, 1.0] };
/// doubling.observe(&[12.0, 5.0]); // about 10 are allowed
/// assert_eq!(doubling.weights(), [-2.0, 1.0]);
/// ```
pub trait Multiplier: Debug + Send {
    /// The scalarisation weights w, one per objective, not normalised; every projection uses their
    /// direction u. A cost's weight is negative, or -0.0 when it is zero:
    /// [`IndependentMin`](crate::projection::IndependentMin) and
    /// [`MeanStd`](crate::projection::MeanStd) would take +0.0 for a reward's weight.
    fn weights(&self) -> &[f32];

    /// The weights of the bounds in what the actor maximises, one per objective.
    fn actor_weights(&self) -> &[f64];

    /// Whether the weights never change, so that the costs need not be estimated.
    fn is_constant(&self) -> bool {
        false
    }

    /// Takes in the batch's mean pessimistic bound at the replayed actions, one value per
    /// objective. Values are discounted, in the units of Q: compare a cost with
    /// [`discounted_limit`](crate::discounted_limit), not with an episode's limit.
    fn observe(&mut self, _bound: &[f32]) {}

    /// Learns from what was last observed.
    fn update(&mut self) {}

    /// Reports the state of the multipliers.
    fn log(&self, _step: u64, _log: &mut dyn Observer) {}

    /// Writes what changes. A multiplier that learns but writes nothing starts afresh when its run
    /// resumes.
    fn save(&self, _state: &mut State) {}

    /// Restores what [`Multiplier::save`] wrote.
    fn load(&mut self, _state: &State) -> Result<()> {
        Ok(())
    }
}

impl Multiplier for Box<dyn Multiplier> {
    fn weights(&self) -> &[f32] {
        self.as_ref().weights()
    }

    fn actor_weights(&self) -> &[f64] {
        self.as_ref().actor_weights()
    }

    fn is_constant(&self) -> bool {
        self.as_ref().is_constant()
    }

    fn observe(&mut self, bound: &[f32]) {
        self.as_mut().observe(bound);
    }

    fn update(&mut self) {
        self.as_mut().update();
    }

    fn log(&self, step: u64, log: &mut dyn Observer) {
        self.as_ref().log(step, log);
    }

    fn save(&self, state: &mut State) {
        self.as_ref().save(state);
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.as_mut().load(state)
    }
}

/// How the limits of a task's costs are enforced.
///
/// ```
/// use copq::{Constraint, EnvSpec, LagrangianConfig, Method};
///
/// let constraint = Constraint::Lagrangian(LagrangianConfig::default());
/// let method = Method::sac().constrain(constraint);
/// assert_eq!(method.config.constraint, Some(constraint));
///
/// // A task without costs has no limit to enforce.
/// let spec = EnvSpec::new("cart", 2, 1).reward("progress", 1.0);
/// assert!(constraint.multiplier(&spec, 0.99).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Constraint {
    /// A Lagrange multiplier for each cost, learned by gradient ascent.
    Lagrangian(LagrangianConfig),
    /// A multiplier for each cost, set by a PID controller.
    Pid(PidConfig),
}

impl Constraint {
    pub(crate) fn check(&self) -> Result<()> {
        match self {
            Self::Lagrangian(config) => config.check(),
            Self::Pid(config) => config.check(),
        }
    }

    /// Multipliers for a task's costs; an error if it has none.
    pub fn multiplier(&self, spec: &EnvSpec, discount: f64) -> Result<Box<dyn Multiplier>> {
        Ok(match *self {
            Self::Lagrangian(config) => Box::new(Lagrangian::new(config, spec, discount)?),
            Self::Pid(config) => Box::new(Pid::new(config, spec, discount)?),
        })
    }
}
