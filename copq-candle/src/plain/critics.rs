//! K critics of candle tensors.

use std::path::Path;

use candle_core::{Device, Tensor, Var};
use copq::error::check_len;
use copq::{Activation, Critic, EnvSpec, Net, Networks, QGrad, QView, Result, Rng, State};

use super::network::{Network, values};
use super::{failed, loss_of, tensors};
use crate::learned::{Learned, load_critics, save_critics};
use crate::shape::Shape;
use crate::{check, weights};

/// An ensemble of separately initialised multilayer perceptrons (observation and action in, N
/// values out).
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
    shape: Shape,
    observation: usize,
    action: usize,
    objectives: usize,
    lr: f64,
    activation: Activation,
    device: Device,
}

impl Critics {
    /// `critics` networks on a device, with fresh weights: the same as the fused ones from an equal
    /// `rng`.
    pub fn new(
        spec: &EnvSpec,
        critics: usize,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        check::settings(spec, networks)?;
        check::positive("critics", critics)?;
        let shape = Shape::critic(spec, networks);
        let learned: Vec<_> =
            (0..critics).map(|_| Learned::new(&shape, networks.init, rng)).collect();
        Ok(Self {
            networks: place(&shape, networks.activation, &learned, device)?,
            shape,
            observation: spec.obs_len,
            action: spec.action_len(),
            objectives: spec.objectives.len(),
            lr: networks.critic_lr,
            activation: networks.activation,
            device: device.clone(),
        })
    }

    /// Writes the online parameters to a safetensors file, as the fused critics do.
    pub fn save_safetensors(&self, path: impl AsRef<Path>) -> Result<()> {
        let learned = self.learned()?;
        let prefixes = weights::critic_prefixes(learned.len());
        let named: Vec<_> =
            prefixes.into_iter().zip(learned.into_iter().map(|learned| learned.online)).collect();
        weights::save(path.as_ref(), &named, &self.shape)
    }

    /// Starts from a safetensors file's parameters: the targets become equal to them and the
    /// optimiser begins anew.
    pub fn load_safetensors(&mut self, path: impl AsRef<Path>) -> Result<()> {
        let online = weights::load(
            path.as_ref(),
            &weights::critic_prefixes(self.networks.len()),
            &self.shape,
        )?;
        let learned: Vec<_> = online.into_iter().map(Learned::from_online).collect();
        self.networks = place(&self.shape, self.activation, &learned, &self.device)?;
        Ok(())
    }

    fn learned(&self) -> Result<Vec<Learned>> {
        self.networks.iter().map(|network| network.learned().map_err(failed)).collect()
    }

    /// A checked batch as tensors: observations `rows x observation` and actions `rows x action`.
    fn tensors(&self, obs: &[f32], act: &[f32]) -> Result<(Tensor, Tensor)> {
        tensors(obs, act, [self.observation, self.action], &self.device)
    }

    /// Every critic's values, `critics x rows x objectives`.
    fn forward(&self, net: Net, obs: &Tensor, act: &Tensor) -> candle_core::Result<Tensor> {
        let input = Tensor::cat(&[obs, act], 1)?;
        let q: Vec<_> = self
            .networks
            .iter()
            .map(|network| network.forward(net, &input))
            .collect::<Result<_, _>>()?;
        Tensor::stack(&q, 0)
    }

    /// A loss whose gradient to q is what `grad` fills.
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
        q.copy_from_slice(&self.forward(net, &obs, &act).and_then(|q| values(&q)).map_err(failed)?);
        Ok(())
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        check::tau(tau)?;
        let (obs, act) = self.tensors(obs, act)?;
        let q = self.forward(Net::Online, &obs, &act).map_err(failed)?;
        let grads = self.loss(&q, grad)?.backward().map_err(failed)?;
        let mut networks = self.networks.iter_mut();
        networks
            .try_for_each(|network| {
                network.step(&grads, self.lr).and_then(|()| network.update_target(tau))
            })
            .map_err(failed)
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
        let q = self.forward(Net::Online, &obs, &act).map_err(failed)?;
        let grads = self.loss(&q, grad)?.backward().map_err(failed)?;
        match grads.get(&act) {
            Some(grad) => out.copy_from_slice(&values(grad).map_err(failed)?),
            None => out.fill(0.0),
        }
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        save_critics(self.learned()?.into_iter(), &self.shape, state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        let learned = load_critics(self.networks.len(), &self.shape, state)?;
        self.networks = place(&self.shape, self.activation, &learned, &self.device)?;
        Ok(())
    }
}

fn place(
    shape: &Shape,
    activation: Activation,
    learned: &[Learned],
    device: &Device,
) -> Result<Vec<Network>> {
    learned
        .iter()
        .map(|learned| Network::new(shape, activation, learned, device).map_err(failed))
        .collect()
}
