//! The multipliers of costs: one rule for each, updated once per epoch.

use super::config::{Ascent, Constraint};
use crate::adam::Adam;
use crate::multiplier::Controller;
use crate::{PidConfig, Result, State};

/// The rule that sets one cost's multiplier.
#[derive(Clone, Debug)]
pub(super) enum Multiplier {
    Pid(PidConfig, Controller),
    Adam { cap: f64, lambda: [f64; 1], adam: Adam },
}

impl Multiplier {
    pub fn new(constraint: Constraint) -> Result<Self> {
        constraint.check()?;
        Ok(match constraint {
            Constraint::Pid(config) => {
                // The multiplier is 0 before the first update.
                Self::Pid(config, Controller::new(&config, 0.0))
            }
            Constraint::Adam(Ascent { lr, multiplier, cap }) => {
                Self::Adam { cap, lambda: [multiplier], adam: Adam::new(lr, 0.0, 1) }
            }
        })
    }

    /// lambda.
    pub fn value(&self) -> f64 {
        match self {
            Self::Pid(_, controller) => controller.lambda,
            Self::Adam { lambda: [lambda], .. } => *lambda,
        }
    }

    /// Learns from the mean cost of an episode.
    pub fn update(&mut self, cost: f64, limit: f64) {
        match self {
            Self::Pid(config, controller) => controller.update(config, cost, cost - limit),
            Self::Adam { cap, lambda, adam } => {
                adam.step(lambda, |_, _| limit - cost);
                lambda[0] = lambda[0].clamp(0.0, *cap);
            }
        }
    }

    pub fn save(&self, state: &mut State) {
        match self {
            Self::Pid(_, controller) => controller.save(state),
            Self::Adam { lambda, adam, .. } => {
                state.put("lambda", *lambda);
                adam.save(state);
            }
        }
    }

    pub fn load(&mut self, state: &State) -> Result<()> {
        match self {
            Self::Pid(_, controller) => controller.load(state),
            Self::Adam { lambda, adam, .. } => {
                state.read("lambda", lambda)?;
                adam.load(state)
            }
        }
    }
}
