//! A deterministic actor of candle tensors.

use std::path::Path;

use candle_core::{Device, Tensor};
use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::failed;
use super::network::{Network, values};
use crate::learned::Learned;
use crate::shape::Shape;
use crate::{check, weights};

/// TD3's policy: observation -> hidden layers with ReLU -> tanh. It needs no noise and has no log-probability.
#[derive(Debug)]
pub struct Deterministic {
    network: Network,
    shape: Shape,
    observation: usize,
    action: usize,
    lr: f64,
    device: Device,
}

impl Deterministic {
    /// An actor on a device, with fresh weights: the same as the fused one from an equal `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, rng: &mut Rng, device: &Device) -> Result<Self> {
        check::settings(spec, networks)?;
        let shape = Shape::actor(spec, networks);
        let learned = Learned::new(&shape, rng);
        Ok(Self {
            network: Network::new(&shape, &learned, device).map_err(failed)?,
            shape,
            observation: spec.observation,
            action: spec.action(),
            lr: networks.actor_lr,
            device: device.clone(),
        })
    }

    /// Writes the online parameters to a safetensors file, as the fused actor does.
    pub fn save_safetensors(&self, path: impl AsRef<Path>) -> Result<()> {
        let learned = self.network.learned().map_err(failed)?;
        weights::save(path.as_ref(), &[(weights::actor_prefix(), &learned.online)], &self.shape)
    }

    /// Starts from a safetensors file's parameters: the target becomes equal to them and the optimiser begins anew.
    pub fn load_safetensors(&mut self, path: impl AsRef<Path>) -> Result<()> {
        let online = weights::load(path.as_ref(), &[weights::actor_prefix()], &self.shape)?;
        online.into_iter().try_for_each(|online| self.place(&Learned::from_online(online)))
    }

    fn place(&mut self, learned: &Learned) -> Result<()> {
        self.network = Network::new(&self.shape, learned, &self.device).map_err(failed)?;
        Ok(())
    }

    /// Actions for a checked batch, `rows x action`.
    fn forward(&self, net: Net, obs: &[f32], rows: usize) -> candle_core::Result<Tensor> {
        let obs = Tensor::from_slice(obs, (rows, self.observation), &self.device)?;
        self.network.forward(net, &obs)?.tanh()
    }
}

impl Actor for Deterministic {
    fn action(&self) -> usize {
        self.action
    }

    fn noise(&self) -> usize {
        0
    }

    fn sample(&mut self, net: Net, obs: &[f32], noise: &[f32], action: &mut [f32], log_prob: &mut [f32]) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        check::deterministic(noise, log_prob)?;
        check::batch("actions", action, rows, self.action)?;
        action.copy_from_slice(&self.forward(net, obs, rows).and_then(|a| values(&a)).map_err(failed)?);
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        check::deterministic(noise, &[])?;
        let output = self.forward(Net::Online, obs, rows).map_err(failed)?;
        let action = values(&output).map_err(failed)?;
        let mut dl = vec![0.0; action.len()];
        grad(Sample { action: &action, log_prob: &[] }, SampleGrad { action: &mut dl, log_prob: &mut [] })?;
        // A loss whose gradient to the actions is `dl`: sum(action * dl), with dl a constant.
        let dl = Tensor::from_vec(dl, output.dims(), &self.device).map_err(failed)?;
        let loss = (output * dl).and_then(|product| product.sum_all()).map_err(failed)?;
        let grads = loss.backward().map_err(failed)?;
        self.network.step(&grads, self.lr).map_err(failed)
    }

    fn noise_grad(&mut self, _obs: &[f32], noise: &[f32], _grad_action: &[f32], out: &mut [f32]) -> Result<()> {
        check::deterministic(noise, out)
    }

    fn track(&mut self, tau: f32) -> Result<()> {
        check::tau(tau)?;
        self.network.track(tau).map_err(failed)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.network.learned().map_err(failed)?.save(&self.shape, state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.place(&Learned::load(&self.shape, state)?)
    }
}
