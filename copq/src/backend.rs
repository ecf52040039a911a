//! The seam to a tensor library: who builds the networks.

use crate::{Actor, Critic, EnvSpec, Networks, Result, Rng};

/// Builds the networks of a [`Learner`](crate::Learner): `copq_candle::Candle`, or your own.
///
/// A backend knows shapes, activations and step sizes ([`Networks`]) and no algorithm: how many
/// critics there are and what becomes of their values is the [`Method`](crate::Method)'s. Weights
/// come from `rng` alone, so that a seed gives the same networks every time.
pub trait Backend {
    /// `count` critics, each of which maps an observation and an action to one value per objective
    /// of the task.
    fn critics(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>>;

    /// A policy for the task.
    fn actor(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        rng: &mut Rng,
    ) -> Result<Box<dyn Actor>>;
}

/// Which kind of policy a method learns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActorKind {
    /// One action for each observation (TD3).
    Deterministic,
    /// A Gaussian, squashed by tanh (SAC).
    Gaussian,
}
