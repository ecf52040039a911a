//! K critics of a user's own architecture.

use candle_core::{Device, Tensor, Var};
use copq::error::check_len;
use copq::{Critic, EnvSpec, Net, Networks, QGrad, QView, Result, Rng, State};

use super::Make;
use super::network::Network;
use crate::check;
use crate::plain::{failed, loss_of, tensors, values};

/// An ensemble of separately initialised modules (observation and action in, N values out).
pub struct ModuleCritics {
    networks: Vec<Network>,
    observation: usize,
    action: usize,
    objectives: usize,
    lr: f64,
    device: Device,
}

impl std::fmt::Debug for ModuleCritics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ModuleCritics")
            .field("critics", &self.networks.len())
            .finish_non_exhaustive()
    }
}

impl ModuleCritics {
    /// `critics` modules on a device, each with fresh weights from `rng`.
    pub fn new(
        make: &Make,
        spec: &EnvSpec,
        networks: &Networks,
        critics: usize,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        check::settings(spec, networks)?;
        check::positive("critics", critics)?;
        let observation = spec.obs_len;
        let action = spec.action_len();
        let objectives = spec.objectives.len();
        let network = |_| Network::new(make, observation + action, objectives, rng, device);
        Ok(Self {
            networks: (0..critics).map(network).collect::<Result<_>>()?,
            observation,
            action,
            objectives,
            lr: networks.critic_lr,
            device: device.clone(),
        })
    }

    /// A checked batch as tensors: observations `rows x observation` and actions `rows x action`.
    fn tensors(&self, obs: &[f32], act: &[f32]) -> Result<(Tensor, Tensor)> {
        tensors(obs, act, [self.observation, self.action], &self.device)
    }

    /// Every critic's values, `critics x rows x objectives`.
    fn forward(&self, net: Net, obs: &Tensor, act: &Tensor) -> Result<Tensor> {
        let input = Tensor::cat(&[obs, act], 1).map_err(failed)?;
        let mut q = Vec::with_capacity(self.networks.len());
        for network in &self.networks {
            q.push(network.forward(net, &input).map_err(failed)?);
        }
        let q = Tensor::stack(&q, 0).map_err(failed)?;
        let wanted = self.networks.len() * obs.dims()[0] * self.objectives;
        check_len("a critic module's values", q.elem_count(), wanted)?;
        Ok(q)
    }
}

impl Critic for ModuleCritics {
    fn critics(&self) -> usize {
        self.networks.len()
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
        let (obs, act) = self.tensors(obs, act)?;
        check_len("critic values", q.len(), self.networks.len() * obs.dims()[0] * self.objectives)?;
        q.copy_from_slice(&values(&self.forward(net, &obs, &act)?).map_err(failed)?);
        Ok(())
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        check::tau(tau)?;
        let (obs, act) = self.tensors(obs, act)?;
        let q = self.forward(Net::Online, &obs, &act)?;
        let filled = &mut |q: &[f32], dq: &mut [f32]| {
            grad(QView::new(q, self.networks.len(), self.objectives)?, dq)
        };
        let grads = loss_of(&q, filled)?.backward().map_err(failed)?;
        for network in &mut self.networks {
            network
                .step(&grads, self.lr)
                .and_then(|()| network.update_target(tau))
                .map_err(failed)?;
        }
        Ok(())
    }

    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()> {
        let (obs, act) = self.tensors(obs, act)?;
        check::batch("action gradients", out, obs.dims()[0], self.action)?;
        let act = Var::from_tensor(&act).map_err(failed)?;
        let q = self.forward(Net::Online, &obs, &act)?;
        let filled = &mut |q: &[f32], dq: &mut [f32]| {
            grad(QView::new(q, self.networks.len(), self.objectives)?, dq)
        };
        let grads = loss_of(&q, filled)?.backward().map_err(failed)?;
        match grads.get(&act) {
            Some(grad) => out.copy_from_slice(&values(grad).map_err(failed)?),
            None => out.fill(0.0),
        }
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        for (k, network) in self.networks.iter().enumerate() {
            network.save(state.child_mut(&format!("critic.{k}")))?;
        }
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        for (k, network) in self.networks.iter_mut().enumerate() {
            network.load(state.child(&format!("critic.{k}"))?)?;
        }
        Ok(())
    }
}
