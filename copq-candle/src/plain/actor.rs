//! A deterministic actor as a candle-nn module.

use candle_core::{Device, Tensor};
use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::body::Body;
use super::{failed, loss_of, values};
use crate::{MakeModule, check};

/// TD3's policy: observation -> network -> tanh. It needs no noise and has no log-probability.
///
/// ```
/// use candle_nn::{VarBuilder, linear};
/// use copq::{Actor, EnvSpec, Net, Networks, Rng, Stream};
/// use copq_candle::{Device, plain};
///
/// // A linear policy, as a module of one layer.
/// let make = |vars: VarBuilder<'_>, input, output| Ok(Box::new(linear(input, output, vars)?) as _);
/// let spec = EnvSpec::new("example", 3, 2).reward("safety", 1.0);
/// let mut rng = Rng::new(0, Stream::Init);
/// let networks = Networks::default();
/// let mut actor =
///     plain::Deterministic::of_module(&make, &spec, &networks, &mut rng, &Device::Cpu)?;
///
/// let mut action = [0.0; 2];
/// actor.mode(Net::Online, &[0.1, 0.2, 0.3], &mut action)?;
/// assert!(action.iter().all(|a| a.abs() < 1.0));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Deterministic(Body);

impl Deterministic {
    /// A multilayer perceptron on a device, with the same fresh weights as the fused one from an
    /// equal `rng`.
    pub fn new(
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        Ok(Self(Body::new(None, spec, networks, spec.action_len(), rng, device)?))
    }

    /// A module on a device, with fresh weights from `rng`. It maps an observation to one number
    /// per action component.
    pub fn of_module(
        make: &MakeModule,
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        let output = spec.action_len();
        Ok(Self(Body::new(Some(make), spec, networks, output, rng, device)?))
    }

    /// Actions for a checked batch, `rows x action`.
    fn forward(&self, net: Net, obs: &[f32], rows: usize) -> Result<Tensor> {
        self.0.forward(net, obs, rows)?.tanh().map_err(failed)
    }
}

impl Actor for Deterministic {
    fn action_len(&self) -> usize {
        self.0.action
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let rows = self.0.rows(obs)?;
        check::batch("actions", action, rows, self.0.action)?;
        action.copy_from_slice(&values(&self.forward(net, obs, rows)?).map_err(failed)?);
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = self.0.rows(obs)?;
        check::deterministic(noise)?;
        let output = self.forward(Net::Online, obs, rows)?;
        let filled = &mut |action: &[f32], dl: &mut [f32]| {
            grad(Sample { action, log_prob: None }, SampleGrad { action: dl, log_prob: None })
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
