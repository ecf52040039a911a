//! A trained policy on its own: what acts when learning is over.

use crate::{Actor, Net, Normaliser, Result, State};

/// An actor with the normaliser of its observations, if it learned with one; both frozen.
///
/// ```
/// # use copq::*;
/// # fn show(actor: Box<dyn Actor>, checkpoint: &State, obs: &[f32]) -> Result<()> {
/// // The state that an agent's `save` wrote, such as the child `agent` of a trainer's.
/// let mut policy = Policy::load(actor, None, checkpoint)?;
/// let mut action = vec![0.0; policy.action()];
/// policy.act(obs, &mut action)?; // in [-1, 1]: see `EnvSpec::scale_action`
/// # Ok(())
/// # }
/// ```
pub struct Policy {
    actor: Box<dyn Actor>,
    normaliser: Option<Normaliser>,
    /// What the actor sees.
    obs: Vec<f32>,
}

impl std::fmt::Debug for Policy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Policy").field("normaliser", &self.normaliser).finish_non_exhaustive()
    }
}

impl Policy {
    /// The policy in an agent's saved state. `actor` must have the saved one's layers; a `normaliser`, of the observations'
    /// length, is there exactly if the run's [`Config::normalise`](crate::Config::normalise) is set.
    pub fn load(mut actor: Box<dyn Actor>, mut normaliser: Option<Normaliser>, agent: &State) -> Result<Self> {
        actor.load(agent.child("actor")?)?;
        Normaliser::restore(&mut normaliser, agent)?;
        Ok(Self { actor, normaliser, obs: Vec::new() })
    }

    /// Length of an action.
    pub fn action(&self) -> usize {
        self.actor.action()
    }

    /// Writes the policy's best guess for one observation, or for each of a batch, in [-1, 1].
    pub fn act(&mut self, obs: &[f32], action: &mut [f32]) -> Result<()> {
        self.obs.clear();
        self.obs.extend_from_slice(obs);
        if let Some(normaliser) = &self.normaliser {
            normaliser.normalise(&mut self.obs)?;
        }
        self.actor.sample(Net::Online, &self.obs, &[], action, &mut [])
    }
}
