//! Settings of a learner, grouped like the tables of the paper, with presets.

use serde::{Deserialize, Serialize};

use crate::{Error, FamoConfig, Result};

/// Network shapes and step sizes, for the backend that builds the networks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Networks {
    /// Widths of the hidden layers, ReLU after each.
    pub hidden: Vec<usize>,
    /// Adam's step size for the critics.
    pub critic_lr: f64,
    /// Adam's step size for the actor.
    pub actor_lr: f64,
}

impl Default for Networks {
    /// Two hidden layers of 256, step sizes 3e-4 (paper Table D.3).
    fn default() -> Self {
        Self { hidden: vec![256, 256], critic_lr: 3e-4, actor_lr: 3e-4 }
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

/// Clipped Gaussian noise on the target policy's actions (TD3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Smoothing {
    /// Standard deviation, in units of half the action range.
    pub std: f64,
    /// Bound on the noise's size, in the same units.
    pub clip: f64,
}

/// What a [`Learner`](crate::Learner) does in an update; the strategies it does it with (projection, exploration,
/// multiplier) are given to the learner itself.
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
    /// Environment steps with uniform actions before the first update.
    pub start_steps: u64,
    /// Updates for each environment step (the update-to-data ratio).
    pub updates_per_step: usize,
    /// Critic updates for each actor update.
    pub actor_delay: u64,
    /// Critic updates for each Polyak step of the targets.
    pub target_period: u64,
    /// kappa, the length of the pessimistic step: the bound is mean - kappa C R u.
    pub pessimism: f64,
    /// Noise on target actions, if any.
    pub smoothing: Option<Smoothing>,
    /// Balancing of the objectives' losses, if any.
    pub famo: Option<FamoConfig>,
    /// Standard deviation of the default Gaussian exploration, in units of half the action range.
    pub exploration_std: f64,
    /// Network shapes and step sizes.
    pub networks: Networks,
}

impl Config {
    /// COP-Q on TD3: the constants of the paper's Table D.3 and D.1. Targets follow at every update; the warm-up,
    /// which the paper leaves open, is TD3's 25,000 steps.
    pub fn td3() -> Self {
        Self {
            discount: 0.99,
            tau: 0.005,
            batch: 256,
            capacity: 1_000_000,
            start_steps: 25_000,
            updates_per_step: 1,
            actor_delay: 2,
            target_period: 1,
            pessimism: 1.0,
            smoothing: Some(Smoothing { std: 0.2, clip: 0.5 }),
            famo: Some(FamoConfig::default()),
            exploration_std: 0.1,
            networks: Networks::default(),
        }
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
        not_negative("pessimism", self.pessimism)?;
        not_negative("exploration_std", self.exploration_std)?;
        if let Some(smoothing) = self.smoothing {
            not_negative("smoothing.std", smoothing.std)?;
            not_negative("smoothing.clip", smoothing.clip)?;
        }
        self.networks.check()
    }
}

fn fraction(name: &str, value: f64) -> Result<()> {
    if (0.0..=1.0).contains(&value) { Ok(()) } else { Err(Error::invalid(name, "a number from 0 to 1", value)) }
}

fn not_negative(name: &str, value: f64) -> Result<()> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(Error::invalid(name, "a finite number, at least 0", value))
    }
}
