//! An unsquashed Gaussian policy in the fast implementation.

use copq::on_policy::{self, Descent, NormalGrad, NormalGradient};
use copq::{ActionGrad, Actor, EnvSpec, Error, Net, Networks, Result, Rng, State};

use super::body::Body;
use super::panels::PanelRow;
use super::passes::room;
use crate::check;
use crate::deviations::Deviations;

/// PPO's policy: observation -> hidden layers -> the means of a Gaussian. Its standard deviations
/// are separate parameters that begin at 1. Its mode is the mean, clamped to [-1, 1].
///
/// ```
/// use copq::on_policy::GaussianPolicy;
/// use copq::{Activation, Actor, EnvSpec, Net, Networks, Rng, Stream};
/// use copq_candle::fused::Normal;
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let networks = Networks { activation: Activation::Tanh, ..Networks::default() };
/// let mut policy = Normal::new(&spec, &networks, &mut Rng::new(0, Stream::Init))?;
/// assert_eq!(policy.log_std(), [0.0]);
///
/// let mut mean = [0.0];
/// let mut mode = [0.0];
/// policy.means(&[0.1, 0.2], &mut mean)?;
/// policy.mode(Net::Online, &[0.1, 0.2], &mut mode)?;
/// assert_eq!(mode[0], mean[0].clamp(-1.0, 1.0));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Normal {
    body: Body,
    deviations: Deviations,
    grad_log_std: Vec<f32>,
    /// For a batch: means, their gradient, and that of the network's parameters.
    mean: Vec<f32>,
    grad_mean: Vec<f32>,
    grad: Vec<PanelRow>,
}

impl Normal {
    /// A policy for an environment, with fresh weights drawn from `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<Self> {
        networks.check_f32("an on-policy network")?;
        let body = Body::new(spec, networks, spec.action_len(), rng)?;
        let zeros = vec![0.0; spec.action_len()];
        Ok(Self {
            body,
            deviations: Deviations::new(zeros.clone()),
            grad_log_std: zeros,
            mean: Vec::new(),
            grad_mean: Vec::new(),
            grad: Vec::new(),
        })
    }

    /// Runs a batch forward, and the gradient that `grad` fills back to the parameters.
    fn backward(&mut self, obs: &[f32], grad: NormalGrad<'_>) -> Result<()> {
        let rows = self.body.rows(obs)?;
        let len = rows * self.deviations.log_std.len();
        let mean = room(&mut self.mean, len);
        self.body.forward(obs, rows, mean);
        let grad_mean = room(&mut self.grad_mean, len);
        grad(
            on_policy::Normal { mean, log_std: &self.deviations.log_std },
            NormalGradient { mean: grad_mean, log_std: &mut self.grad_log_std },
        )?;
        self.body.gradient(grad_mean, &mut self.grad);
        Ok(())
    }
}

impl Actor for Normal {
    fn action_len(&self) -> usize {
        self.deviations.log_std.len()
    }

    fn mode(&mut self, _: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        on_policy::GaussianPolicy::means(self, obs, action)?;
        action.iter_mut().for_each(|action| *action = action.clamp(-1.0, 1.0));
        Ok(())
    }

    fn improve(&mut self, _: &[f32], _: &[f32], _: ActionGrad<'_>) -> Result<()> {
        let what =
            "this policy learns by on_policy::GaussianPolicy::descend, not by Actor::improve";
        Err(Error::Unsupported { what: what.to_owned() })
    }

    fn update_target(&mut self, _: f32) -> Result<()> {
        Ok(())
    }

    fn export(&self, state: &mut State) -> Result<()> {
        self.body.export(state)?;
        self.deviations.export(state);
        Ok(())
    }

    fn import(&mut self, state: &State) -> Result<()> {
        let deviations = self.deviations.import(state)?;
        self.body.import(state)?;
        self.deviations = deviations;
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.body.save(state)?;
        self.deviations.save(state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        let deviations = self.deviations.load(state)?;
        self.body.load(state)?;
        self.deviations = deviations;
        Ok(())
    }
}

impl on_policy::GaussianPolicy for Normal {
    fn log_std(&self) -> &[f32] {
        &self.deviations.log_std
    }

    fn means(&mut self, obs: &[f32], mean: &mut [f32]) -> Result<()> {
        let rows = self.body.rows(obs)?;
        check::batch("means", mean, rows, self.deviations.log_std.len())?;
        self.body.values(Net::Online, obs, rows, mean);
        Ok(())
    }

    fn descend(&mut self, obs: &[f32], step: Descent, grad: NormalGrad<'_>) -> Result<()> {
        self.backward(obs, grad)?;
        let Self { deviations, grad_log_std: grad, .. } = self;
        let penalty = 2.0 * step.decay as f32;
        grad.iter_mut().zip(&deviations.log_std).for_each(|(grad, x)| *grad += penalty * x);
        let more = grad.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
        let factor = self.body.descend(&mut self.grad, more, step);
        grad.iter_mut().for_each(|grad| *grad *= factor);
        deviations.step(grad, step.lr, self.body.network.steps());
        Ok(())
    }

    fn parameters(&self) -> usize {
        self.body.network.shape().len() + self.deviations.log_std.len()
    }

    fn gradient(&mut self, obs: &[f32], grad: NormalGrad<'_>, out: &mut [f32]) -> Result<()> {
        check::batch("gradient", out, self.parameters(), 1)?;
        self.backward(obs, grad)?;
        let (network, log_std) = out.split_at_mut(self.body.network.shape().len());
        network.copy_from_slice(&self.body.network.flat(&self.grad));
        log_std.copy_from_slice(&self.grad_log_std);
        Ok(())
    }

    fn push_forward(&mut self, obs: &[f32], direction: &[f32], out: &mut [f32]) -> Result<()> {
        let rows = self.body.rows(obs)?;
        check::batch("direction", direction, self.parameters(), 1)?;
        check::batch("moved means", out, rows, self.deviations.log_std.len())?;
        let mean = room(&mut self.mean, out.len());
        self.body.forward(obs, rows, mean);
        let Body { network, input, workspace, .. } = &self.body;
        let direction = &direction[..network.shape().len()];
        network.push_forward(input, direction, out, workspace);
        Ok(())
    }

    fn shift(&mut self, step: &[f32]) -> Result<()> {
        check::batch("step", step, self.parameters(), 1)?;
        let (network, log_std) = step.split_at(self.body.network.shape().len());
        self.body.network.shift(network);
        self.deviations.log_std.iter_mut().zip(log_std).for_each(|(x, step)| *x += step);
        Ok(())
    }
}
