//! What both actors are made of: a network that reads observations, and its optimiser.

use std::path::Path;

use candle_core::backprop::GradStore;
use candle_core::{Device, Tensor};
use copq::{Activation, EnvSpec, Net, Networks, Result, Rng, State};

use super::failed;
use super::network::Network;
use crate::learned::Learned;
use crate::shape::Shape;
use crate::{check, weights};

/// A network from observations to whatever an actor makes actions of.
#[derive(Debug)]
pub(super) struct Policy {
    network: Network,
    shape: Shape,
    observation: usize,
    /// Components of an action.
    pub action: usize,
    lr: f64,
    activation: Activation,
    pub device: Device,
}

impl Policy {
    /// A network of the shape that an actor wants, with fresh weights drawn from `rng`.
    pub fn new(
        spec: &EnvSpec,
        networks: &Networks,
        shape: impl Fn(&EnvSpec, &Networks) -> Shape,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        check::settings(spec, networks)?;
        let shape = shape(spec, networks);
        let learned = Learned::new(&shape, networks.init, rng);
        Ok(Self {
            network: Network::new(&shape, networks.activation, &learned, device).map_err(failed)?,
            shape,
            observation: spec.obs_len,
            action: spec.action_len(),
            lr: networks.actor_lr,
            activation: networks.activation,
            device: device.clone(),
        })
    }

    /// The number of rows in a batch of observations.
    pub fn rows(&self, obs: &[f32]) -> Result<usize> {
        check::rows(obs, self.observation)
    }

    /// The network's output for a checked batch, `rows x output`.
    pub fn forward(&self, net: Net, obs: &[f32], rows: usize) -> candle_core::Result<Tensor> {
        self.network.forward(net, &Tensor::from_slice(obs, (rows, self.observation), &self.device)?)
    }

    /// See [`Network::step`].
    pub fn step(&mut self, grads: &GradStore) -> candle_core::Result<()> {
        self.network.step(grads, self.lr)
    }

    pub fn update_target(&mut self, tau: f32) -> Result<()> {
        check::tau(tau)?;
        self.network.update_target(tau).map_err(failed)
    }

    pub fn save_safetensors(&self, path: &Path) -> Result<()> {
        let learned = self.network.learned().map_err(failed)?;
        weights::save(path, &[(weights::actor_prefix(), learned.online)], &self.shape)
    }

    pub fn load_safetensors(&mut self, path: &Path) -> Result<()> {
        let online = weights::load(path, &[weights::actor_prefix()], &self.shape)?;
        online.into_iter().try_for_each(|online| self.place(&Learned::from_online(online)))
    }

    pub fn export(&self, state: &mut State) -> Result<()> {
        Learned::export(&self.network.learned().map_err(failed)?.online, &self.shape, state);
        Ok(())
    }

    pub fn import(&mut self, state: &State) -> Result<()> {
        self.place(&Learned::from_online(Learned::import(&self.shape, state)?))
    }

    pub fn save(&self, state: &mut State) -> Result<()> {
        self.network.learned().map_err(failed)?.save(&self.shape, state);
        Ok(())
    }

    pub fn load(&mut self, state: &State) -> Result<()> {
        self.place(&Learned::load(&self.shape, state)?)
    }

    fn place(&mut self, learned: &Learned) -> Result<()> {
        self.network =
            Network::new(&self.shape, self.activation, learned, &self.device).map_err(failed)?;
        Ok(())
    }
}
