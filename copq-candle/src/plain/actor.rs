//! A deterministic actor of candle tensors.

use std::path::Path;

use candle_core::{Device, Tensor};
use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::network::values;
use super::policy::Policy;
use super::{failed, loss_of};
use crate::check;
use crate::shape::Shape;

/// TD3's policy: observation -> hidden layers with ReLU -> tanh. It needs no noise and has no
/// log-probability.
#[derive(Debug)]
pub struct Deterministic(Policy);

impl Deterministic {
    /// An actor on a device, with fresh weights: the same as the fused one from an equal `rng`.
    pub fn new(
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        Ok(Self(Policy::new(spec, networks, Shape::actor, rng, device)?))
    }

    /// Writes the online parameters to a safetensors file, as the fused actor does.
    ///
    /// They are for observations as the network saw them: normalised, if the learner had a
    /// normaliser, which is not saved here.
    pub fn save_safetensors(&self, path: impl AsRef<Path>) -> Result<()> {
        self.0.save_safetensors(path.as_ref())
    }

    /// Starts from a safetensors file's parameters: the target becomes equal to them and the
    /// optimiser begins anew.
    pub fn load_safetensors(&mut self, path: impl AsRef<Path>) -> Result<()> {
        self.0.load_safetensors(path.as_ref())
    }

    /// Actions for a checked batch, `rows x action`.
    fn forward(&self, net: Net, obs: &[f32], rows: usize) -> candle_core::Result<Tensor> {
        self.0.forward(net, obs, rows)?.tanh()
    }
}

impl Actor for Deterministic {
    fn action_len(&self) -> usize {
        self.0.action
    }

    fn noise_len(&self) -> usize {
        0
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let rows = self.0.rows(obs)?;
        check::batch("actions", action, rows, self.0.action)?;
        action.copy_from_slice(
            &self.forward(net, obs, rows).and_then(|a| values(&a)).map_err(failed)?,
        );
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = self.0.rows(obs)?;
        check::deterministic(noise)?;
        let output = self.forward(Net::Online, obs, rows).map_err(failed)?;
        let filled = &mut |action: &[f32], dl: &mut [f32]| {
            grad(Sample { action, log_prob: &[] }, SampleGrad { action: dl, log_prob: &mut [] })
        };
        let grads = loss_of(&output, filled)?.backward().map_err(failed)?;
        self.0.step(&grads).map_err(failed)
    }

    fn update_target(&mut self, tau: f32) -> Result<()> {
        self.0.update_target(tau)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.0.save(state)
    }

    fn export(&self, state: &mut State) -> Result<()> {
        self.0.export(state)
    }

    fn import(&mut self, state: &State) -> Result<()> {
        self.0.import(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.0.load(state)
    }
}
