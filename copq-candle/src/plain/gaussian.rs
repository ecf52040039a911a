//! A squashed Gaussian actor as a candle-nn module.

use candle_core::{Device, Tensor, Var};
use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::body::Body;
use super::{failed, values};
use crate::squash::LOG_STD;
use crate::{MakeModule, check};

/// SAC's policy, like the fused one: see [`crate::fused::Gaussian`].
///
/// ```
/// use copq::{Actor, EnvSpec, Net, Networks, Rng, Stream};
/// use copq_candle::{Device, fused, plain};
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let networks = Networks::default();
/// let rng = || Rng::new(0, Stream::Init);
/// let mut readable = plain::Gaussian::new(&spec, &networks, &mut rng(), &Device::Cpu)?;
/// let mut fast = fused::Gaussian::new(&spec, &networks, &mut rng())?;
///
/// let mut action = [[0.0], [0.0]];
/// let mut log_prob = [[0.0], [0.0]];
/// let (obs, noise) = ([0.1, 0.2], [1.5]);
/// readable.sample(Net::Online, &obs, &noise, &mut action[0], &mut log_prob[0])?;
/// fast.sample(Net::Online, &obs, &noise, &mut action[1], &mut log_prob[1])?;
/// assert!((action[0][0] - action[1][0]).abs() < 1e-6);
/// assert!((log_prob[0][0] - log_prob[1][0]).abs() < 1e-5);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Gaussian(Body);

impl Gaussian {
    /// A multilayer perceptron on a device, with the same fresh weights as the fused one from an
    /// equal `rng`.
    pub fn new(
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        Ok(Self(Body::new(None, spec, networks, 2 * spec.action_len(), rng, device)?))
    }

    /// A module on a device, with fresh weights from `rng`. It maps an observation to the means of
    /// all action components before the tanh, then their log stds.
    pub fn of_module(
        make: &MakeModule,
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        let output = 2 * spec.action_len();
        Ok(Self(Body::new(Some(make), spec, networks, output, rng, device)?))
    }

    /// A checked batch's mean and log std, each `rows x action`.
    fn forward(&self, net: Net, obs: &[f32], rows: usize) -> Result<(Tensor, Tensor)> {
        let output = self.0.forward(net, obs, rows)?;
        let split = || {
            let mean = output.narrow(1, 0, self.0.action)?;
            let log_std = output.narrow(1, self.0.action, self.0.action)?;
            Ok((mean, log_std.clamp(LOG_STD.0, LOG_STD.1)?))
        };
        split().map_err(failed)
    }

    /// Actions (`rows x action`) and log-probabilities (`rows`) for noise (`rows x action`).
    fn squashed(&self, net: Net, obs: &[f32], noise: &Tensor) -> Result<(Tensor, Tensor)> {
        let (mean, log_std) = self.forward(net, obs, noise.dims()[0])?;
        squash(&mean, &log_std, noise).map_err(failed)
    }

    fn noise_tensor(&self, noise: &[f32], rows: usize) -> Result<Tensor> {
        Tensor::from_slice(noise, (rows, self.0.action), &self.0.device).map_err(failed)
    }
}

/// tanh(mean + std noise), and its log-probability.
fn squash(
    mean: &Tensor,
    log_std: &Tensor,
    noise: &Tensor,
) -> candle_core::Result<(Tensor, Tensor)> {
    let x = (mean + (log_std.exp()? * noise)?)?;
    let gaussian = ((noise.sqr()? * -0.5)? - log_std)?;
    // log(1 - tanh(x)^2) = 2 (log 2 - x - softplus(-2x))
    let correction = ((softplus(&(&x * -2.0)?)? + &x)?.neg()? * 2.0)?;
    let constants = -0.5 * libm::log(std::f64::consts::TAU) - 2.0 * std::f64::consts::LN_2;
    let log_prob = ((gaussian - correction)? + constants)?.sum(1)?;
    Ok((x.tanh()?, log_prob))
}

/// log(1 + exp(y)), for any y.
fn softplus(y: &Tensor) -> candle_core::Result<Tensor> {
    y.relu()? + (y.abs()?.neg()?.exp()? + 1.0)?.log()?
}

impl Actor for Gaussian {
    fn action_len(&self) -> usize {
        self.0.action
    }

    fn noise_len(&self) -> usize {
        self.0.action
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let rows = self.0.rows(obs)?;
        check::batch("actions", action, rows, self.0.action)?;
        let (mean, _) = self.forward(net, obs, rows)?;
        action.copy_from_slice(&mean.tanh().and_then(|mode| values(&mode)).map_err(failed)?);
        Ok(())
    }

    fn sample(
        &mut self,
        net: Net,
        obs: &[f32],
        noise: &[f32],
        action: &mut [f32],
        log_prob: &mut [f32],
    ) -> Result<()> {
        let rows = self.0.rows(obs)?;
        check::sample(noise, action, log_prob, rows, self.0.action)?;
        let noise = self.noise_tensor(noise, rows)?;
        let (sampled, log) = self.squashed(net, obs, &noise)?;
        action.copy_from_slice(&values(&sampled).map_err(failed)?);
        log_prob.copy_from_slice(&values(&log).map_err(failed)?);
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = self.0.rows(obs)?;
        check::batch("noise", noise, rows, self.0.action)?;
        let noise = self.noise_tensor(noise, rows)?;
        let (sampled, log) = self.squashed(Net::Online, obs, &noise)?;
        let action = values(&sampled).map_err(failed)?;
        let log_prob = values(&log).map_err(failed)?;
        let mut da = vec![0.0; action.len()];
        let mut dlog = vec![0.0; rows];
        let sample = Sample { action: &action, log_prob: Some(&log_prob) };
        grad(sample, SampleGrad { action: &mut da, log_prob: Some(&mut dlog) })?;
        let Self(policy) = self;
        let step = || {
            // A loss with these gradients: sum(action * da) + sum(log_prob * dlog), with da and
            // dlog constants.
            let da = Tensor::from_vec(da, sampled.dims(), &policy.device)?;
            let dlog = Tensor::from_vec(dlog, log.dims(), &policy.device)?;
            let loss = ((sampled * da)?.sum_all()? + (log * dlog)?.sum_all()?)?;
            policy.step(&loss.backward()?)
        };
        step().map_err(failed)
    }

    fn noise_grad(
        &mut self,
        obs: &[f32],
        noise: &[f32],
        grad_action: &[f32],
        out: &mut [f32],
    ) -> Result<()> {
        let rows = self.0.rows(obs)?;
        for (what, values) in
            [("noise", noise), ("action gradients", grad_action), ("noise gradients", &*out)]
        {
            check::batch(what, values, rows, self.0.action)?;
        }
        let noise = Var::from_tensor(&self.noise_tensor(noise, rows)?).map_err(failed)?;
        let (sampled, _) = self.squashed(Net::Online, obs, &noise)?;
        let slopes = || {
            let grad = Tensor::from_slice(grad_action, sampled.dims(), &self.0.device)?;
            let grads = (sampled * grad)?.sum_all()?.backward()?;
            grads.get(&noise).map_or(Ok(vec![0.0; grad_action.len()]), values)
        };
        out.copy_from_slice(&slopes().map_err(failed)?);
        Ok(())
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
