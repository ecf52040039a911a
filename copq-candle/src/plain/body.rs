//! The common part of actors: a network that reads observations, and its optimiser.

use candle_core::backprop::GradStore;
use candle_core::{Device, Tensor};
use copq::{EnvSpec, Net, Networks, Result, Rng, State};

use super::network::Network;
use super::perceptron::network;
use super::{check_output, failed};
use crate::learned::Learned;
use crate::{MakeModule, check};

/// A network from observations to outputs that its owner interprets.
#[derive(Debug)]
pub(super) struct Body {
    network: Network,
    observation: usize,
    /// Components of an action.
    pub action: usize,
    /// Number of outputs of the network.
    output: usize,
    lr: f64,
    pub device: Device,
}

impl Body {
    /// A network with `output` outputs and fresh weights drawn from `rng`: the user's module, if
    /// there is one.
    pub fn new(
        make: Option<&MakeModule>,
        spec: &EnvSpec,
        networks: &Networks,
        output: usize,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        check::plain_settings(spec, networks)?;
        Ok(Self {
            network: network(make, spec.obs_len, output, networks, rng, device)?,
            observation: spec.obs_len,
            action: spec.action_len(),
            output,
            lr: networks.actor_lr,
            device: device.clone(),
        })
    }

    /// The number of rows in a batch of observations.
    pub fn rows(&self, obs: &[f32]) -> Result<usize> {
        check::rows(obs, self.observation)
    }

    /// The network's output for a checked batch, `rows x output`.
    pub fn forward(&self, net: Net, obs: &[f32], rows: usize) -> Result<Tensor> {
        let obs =
            Tensor::from_slice(obs, (rows, self.observation), &self.device).map_err(failed)?;
        let output = self.network.forward(net, &obs).map_err(failed)?;
        check_output("a module's output for observations", &output, rows, self.output)?;
        Ok(output)
    }

    /// See [`Network::step`].
    pub fn step(&mut self, grads: &GradStore) -> candle_core::Result<()> {
        self.network.step(grads, self.lr)
    }

    pub fn update_target(&mut self, tau: f32) -> Result<()> {
        check::tau(tau)?;
        self.network.update_target(tau).map_err(failed)
    }

    pub fn export(&self, state: &mut State) -> Result<()> {
        Learned::export(&self.network.learned()?.online, self.network.arrays(), state);
        Ok(())
    }

    pub fn import(&mut self, state: &State) -> Result<()> {
        let online = Learned::import(self.network.arrays(), state)?;
        self.network.set_learned(&Learned::from_online(online))
    }

    pub fn save(&self, state: &mut State) -> Result<()> {
        self.network.learned()?.save(self.network.arrays(), state);
        Ok(())
    }

    pub fn load(&mut self, state: &State) -> Result<()> {
        self.network.set_learned(&Learned::load(self.network.arrays(), state)?)
    }
}
