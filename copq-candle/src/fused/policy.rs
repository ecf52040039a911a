//! What both actors are made of: a network that reads observations, and its optimiser.

use std::path::Path;

use copq::{EnvSpec, Net, Networks, Result, Rng, State};

use super::network::Network;
use crate::learned::Learned;
use crate::shape::Shape;
use crate::{check, weights};

/// A network from observations to whatever an actor makes actions of.
#[derive(Debug)]
pub(super) struct Policy {
    network: Network,
    observation: usize,
    /// Components of an action.
    pub action: usize,
    lr: f64,
}

impl Policy {
    /// A network of the shape that an actor wants, with fresh weights drawn from `rng`.
    pub fn new(
        spec: &EnvSpec,
        networks: &Networks,
        shape: impl Fn(&EnvSpec, &Networks) -> Shape,
        rng: &mut Rng,
    ) -> Result<Self> {
        check::settings(spec, networks)?;
        let shape = shape(spec, networks);
        let learned = Learned::new(&shape, rng);
        let network = Network::new(shape, learned);
        Ok(Self { network, observation: spec.observation, action: spec.action(), lr: networks.actor_lr })
    }

    /// The number of rows in a batch of observations.
    pub fn rows(&self, obs: &[f32]) -> Result<usize> {
        check::rows(obs, self.observation)
    }

    /// See [`Network::forward`].
    pub fn forward(&mut self, net: Net, obs: &[f32], rows: usize, out: &mut [f32]) {
        self.network.forward(net, obs, rows, out);
    }

    /// See [`Network::learn`].
    pub fn learn(&mut self, obs: &[f32], rows: usize, grad_out: &[f32]) {
        self.network.learn(obs, rows, grad_out, self.lr);
    }

    pub fn track(&mut self, tau: f32) -> Result<()> {
        check::tau(tau)?;
        self.network.track(tau);
        Ok(())
    }

    pub fn save_safetensors(&self, path: &Path) -> Result<()> {
        let named = [(weights::actor_prefix(), self.network.learned().online.as_slice())];
        weights::save(path, &named, self.network.shape())
    }

    pub fn load_safetensors(&mut self, path: &Path) -> Result<()> {
        let online = weights::load(path, &[weights::actor_prefix()], self.network.shape())?;
        online.into_iter().for_each(|online| self.network.set_learned(Learned::from_online(online)));
        Ok(())
    }

    pub fn save(&self, state: &mut State) -> Result<()> {
        self.network.save(state);
        Ok(())
    }

    pub fn load(&mut self, state: &State) -> Result<()> {
        self.network.load(state)
    }
}
