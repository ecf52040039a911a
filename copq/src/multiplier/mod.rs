//! Where the scalarisation weights come from: constants, or multipliers that learn to hold a
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
pub use pid::{Pid, PidConfig};

use crate::{EnvSpec, Observer, Result, State};

/// The current weights of the objectives, and what moves them.
///
/// At every update of the actor the learner first shows the costs ([`Multiplier::observe`]), then
/// improves the actor with [`Multiplier::actor_weights`], then lets the multiplier learn
/// ([`Multiplier::update`]).
pub trait Multiplier: Debug + Send {
    /// The scalarisation weights w, one per objective, not normalised: their direction u is every
    /// projection's.
    fn weights(&self) -> &[f32];

    /// The weights of the bounds in what the actor maximises, one per objective.
    fn actor_weights(&self) -> &[f64];

    /// Whether the weights never change, so that nobody need estimate the costs.
    fn is_constant(&self) -> bool {
        false
    }

    /// Takes in the batch's mean pessimistic bound at the replayed actions, one value per
    /// objective.
    fn observe(&mut self, _bound: &[f32]) {}

    /// Learns from what was last observed.
    fn update(&mut self) {}

    /// Reports what there is to know about the multipliers.
    fn log(&self, _step: u64, _log: &mut dyn Observer) {}

    /// Writes what changes.
    fn save(&self, _state: &mut State) {}

    /// Restores what [`Multiplier::save`] wrote.
    fn load(&mut self, _state: &State) -> Result<()> {
        Ok(())
    }
}

/// How the limits of a task's costs are held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Constraint {
    /// A Lagrange multiplier for each cost, learned by gradient ascent.
    Lagrangian(LagrangianConfig),
    /// A multiplier for each cost, set by a PID controller.
    Pid(PidConfig),
}

impl Constraint {
    /// Multipliers for a task's costs; an error if it has none.
    pub fn multiplier(&self, spec: &EnvSpec, discount: f64) -> Result<Box<dyn Multiplier>> {
        Ok(match *self {
            Self::Lagrangian(config) => Box::new(Lagrangian::new(config, spec, discount)?),
            Self::Pid(config) => Box::new(Pid::new(config, spec, discount)?),
        })
    }
}
