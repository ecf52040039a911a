//! Where the scalarisation weights come from: constants, or multipliers that learn to hold a constraint.

use std::fmt::Debug;

use crate::{Error, Result, State};

/// The current scalarisation weights, one an objective, not normalised.
pub trait Multiplier: Debug + Send {
    /// The weights to use now, in targets and in the actor.
    fn weights(&self) -> &[f32];

    /// Learns from the batch's mean pessimistic bound at the replayed actions, one value an objective.
    fn update(&mut self, bound: &[f32]) -> Result<()>;

    /// Writes what changes.
    fn save(&self, state: &mut State);

    /// Restores what [`Multiplier::save`] wrote.
    fn load(&mut self, state: &State) -> Result<()>;
}

/// Constant weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixed(Vec<f32>);

impl Fixed {
    /// Weights that never change; at least one must be non-zero and all finite.
    pub fn new(weights: &[f32]) -> Result<Self> {
        if weights.iter().any(|w| !w.is_finite()) || weights.iter().all(|&w| w == 0.0) {
            return Err(Error::invalid(
                "scalarisation weights",
                "finite numbers, not all zero",
                format!("{weights:?}"),
            ));
        }
        Ok(Self(weights.to_vec()))
    }
}

impl Multiplier for Fixed {
    fn weights(&self) -> &[f32] {
        &self.0
    }

    fn update(&mut self, _bound: &[f32]) -> Result<()> {
        Ok(())
    }

    fn save(&self, _state: &mut State) {}

    fn load(&mut self, _state: &State) -> Result<()> {
        Ok(())
    }
}
