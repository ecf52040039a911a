//! A deterministic policy of a user's own architecture.

use candle_core::{Device, Tensor};
use copq::error::check_len;
use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::Make;
use super::network::Network;
use crate::check;
use crate::plain::{failed, loss_of, values};

/// A module whose output tanh brings to [-1, 1].
pub struct ModuleActor {
    network: Network,
    observation: usize,
    action: usize,
    lr: f64,
    device: Device,
}

impl std::fmt::Debug for ModuleActor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ModuleActor").field("action", &self.action).finish_non_exhaustive()
    }
}

impl ModuleActor {
    /// A module on a device, with fresh weights from `rng`.
    pub fn new(
        make: &Make,
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        check::settings(spec, networks)?;
        Ok(Self {
            network: Network::new(make, spec.obs_len, spec.action_len(), rng, device)?,
            observation: spec.obs_len,
            action: spec.action_len(),
            lr: networks.actor_lr,
            device: device.clone(),
        })
    }

    /// Actions of a checked batch, `rows x action`.
    fn forward(&self, net: Net, obs: &[f32], rows: usize) -> Result<Tensor> {
        let obs =
            Tensor::from_slice(obs, (rows, self.observation), &self.device).map_err(failed)?;
        let action =
            self.network.forward(net, &obs).and_then(|output| output.tanh()).map_err(failed)?;
        check_len("a policy module's actions", action.elem_count(), rows * self.action)?;
        Ok(action)
    }
}

impl Actor for ModuleActor {
    fn action_len(&self) -> usize {
        self.action
    }

    fn noise_len(&self) -> usize {
        0
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        check::batch("actions", action, rows, self.action)?;
        action.copy_from_slice(&values(&self.forward(net, obs, rows)?).map_err(failed)?);
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        check::deterministic(noise)?;
        let output = self.forward(Net::Online, obs, rows)?;
        let filled = &mut |action: &[f32], dl: &mut [f32]| {
            grad(Sample { action, log_prob: &[] }, SampleGrad { action: dl, log_prob: &mut [] })
        };
        let grads = loss_of(&output, filled)?.backward().map_err(failed)?;
        self.network.step(&grads, self.lr).map_err(failed)
    }

    fn update_target(&mut self, tau: f32) -> Result<()> {
        check::tau(tau)?;
        self.network.update_target(tau).map_err(failed)
    }

    fn export(&self, state: &mut State) -> Result<()> {
        self.network.export(state)
    }

    fn import(&mut self, state: &State) -> Result<()> {
        self.network.import(state)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.network.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.network.load(state)
    }
}
