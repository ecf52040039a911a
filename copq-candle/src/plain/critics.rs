//! K critics as candle-nn modules.

use candle_core::{Device, Tensor, Var};
use copq::error::{check_count, check_len};
use copq::{Critic, EnvSpec, Net, Networks, QGrad, QView, Result, Rng, State};

use super::network::Network;
use super::perceptron::network;
use super::{check_output, failed, loss_of, values};
use crate::learned::{load_critics, save_critics};
use crate::shape::Array;
use crate::{MakeModule, check};

/// An ensemble of separately initialised networks (observation and action in, N values out):
/// multilayer perceptrons, or modules of your own.
///
/// ```
/// use copq::{Critic, EnvSpec, Net, Networks, Rng, Stream};
/// use copq_candle::{Device, fused, plain};
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let networks = Networks::default();
/// let rng = || Rng::new(0, Stream::Init);
/// let mut readable = plain::Critics::new(&spec, 2, &networks, &mut rng(), &Device::Cpu)?;
/// let mut fast = fused::Critics::new(&spec, 2, &networks, &mut rng())?;
///
/// let mut q = [[0.0; 2]; 2];
/// readable.values(Net::Online, &[0.1, 0.2], &[0.5], &mut q[0])?;
/// fast.values(Net::Online, &[0.1, 0.2], &[0.5], &mut q[1])?;
/// assert!(q[0].iter().zip(q[1]).all(|(readable, fast)| (readable - fast).abs() < 1e-6));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Critics {
    networks: Vec<Network>,
    observation: usize,
    action: usize,
    objectives: usize,
    lr: f64,
    device: Device,
}

impl Critics {
    /// `critics` multilayer perceptrons on a device, with the same fresh weights as the fused ones
    /// from an equal `rng`.
    pub fn new(
        spec: &EnvSpec,
        critics: usize,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        Self::build(None, spec, critics, networks, rng, device)
    }

    /// `critics` modules on a device, each with fresh weights from `rng`. A module maps an
    /// observation and an action, `obs_len + action_len` numbers, to one per objective.
    pub fn of_modules(
        make: &MakeModule,
        spec: &EnvSpec,
        critics: usize,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        Self::build(Some(make), spec, critics, networks, rng, device)
    }

    fn build(
        make: Option<&MakeModule>,
        spec: &EnvSpec,
        critics: usize,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        check::plain_settings(spec, networks)?;
        check_count("critics", critics)?;
        let input = spec.obs_len + spec.action_len();
        let output = spec.objectives.len();
        let fresh = |_| network(make, input, output, networks, rng, device);
        Ok(Self {
            networks: (0..critics).map(fresh).collect::<Result<_>>()?,
            observation: spec.obs_len,
            action: spec.action_len(),
            objectives: output,
            lr: networks.critic_lr,
            device: device.clone(),
        })
    }

    fn arrays(&self) -> &[Array] {
        self.networks[0].arrays() // There is at least one critic.
    }

    /// A checked batch as tensors: observations `rows x observation` and actions `rows x action`.
    fn tensors(&self, obs: &[f32], act: &[f32]) -> Result<(Tensor, Tensor)> {
        let rows = check::rows(obs, self.observation)?;
        check::batch("actions", act, rows, self.action)?;
        check::finite("actions", act, self.action)?;
        let tensor = |numbers: &[f32], width: usize| {
            Tensor::from_slice(numbers, (rows, width), &self.device).map_err(failed)
        };
        Ok((tensor(obs, self.observation)?, tensor(act, self.action)?))
    }

    /// Every critic's values, `critics x rows x objectives`.
    fn forward(&self, net: Net, obs: &Tensor, act: &Tensor) -> Result<Tensor> {
        let input = Tensor::cat(&[obs, act], 1).map_err(failed)?;
        let mut q = Vec::with_capacity(self.networks.len());
        for network in &self.networks {
            let values = network.forward(net, &input).map_err(failed)?;
            check_output("a critic module's values", &values, obs.dims()[0], self.objectives)?;
            q.push(values);
        }
        Tensor::stack(&q, 0).map_err(failed)
    }

    /// A loss whose gradient with respect to q is what `grad` fills.
    fn loss(&self, q: &Tensor, grad: QGrad<'_>) -> Result<Tensor> {
        loss_of(q, &mut |q, dq| grad(QView::new(q, self.networks.len(), self.objectives)?, dq))
    }
}

impl Critic for Critics {
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
        let grads = self.loss(&q, grad)?.backward().map_err(failed)?;
        for network in &mut self.networks {
            network.step(&grads, self.lr).map_err(failed)?;
            network.update_target(tau).map_err(failed)?;
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
        let grads = self.loss(&q, grad)?.backward().map_err(failed)?;
        match grads.get(&act) {
            Some(grad) => out.copy_from_slice(&values(grad).map_err(failed)?),
            None => out.fill(0.0),
        }
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        let learned: Result<Vec<_>> = self.networks.iter().map(Network::learned).collect();
        save_critics(learned?.into_iter(), self.arrays(), state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        let learned = load_critics(self.networks.len(), self.arrays(), state)?;
        for (network, learned) in self.networks.iter_mut().zip(&learned) {
            network.set_learned(learned)?;
        }
        Ok(())
    }
}
