//! A Gaussian policy that nothing squashes, readable.

use candle_core::{Device, Tensor, Var};
use copq::on_policy::{self, Descent, NormalGrad, NormalGradient};
use copq::{ActionGrad, Actor, EnvSpec, Error, Net, Networks, Result, Rng, State};

use super::body::Body;
use super::value::{factor, with_penalty};
use super::{failed, values};
use crate::check;
use crate::deviations::Deviations;

/// PPO's policy: observation -> hidden layers -> the means of a Gaussian, whose deviations are
/// parameters of their own that begin at 1. It is [`fused::Normal`](crate::fused::Normal) by
/// autograd, on any device, but for natural gradients, which it has not.
///
/// ```
/// use copq::on_policy::GaussianPolicy;
/// use copq::{EnvSpec, Networks, Rng, Stream};
/// use copq_candle::{Device, plain::Normal};
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let rng = &mut Rng::new(0, Stream::Init);
/// let mut policy = Normal::new(&spec, &Networks::default(), rng, &Device::Cpu)?;
/// let mut mean = [0.0];
/// policy.means(&[0.1, 0.2], &mut mean)?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Normal {
    body: Body,
    log_std: Var,
    /// The same as numbers.
    deviations: Deviations,
}

impl Normal {
    /// A policy for an environment, with fresh weights drawn from `rng`.
    pub fn new(
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        let zeros = vec![0.0; spec.action_len()];
        let log_std = Tensor::from_slice(&zeros, zeros.len(), device).map_err(failed)?;
        Ok(Self {
            body: Body::new(None, spec, networks, zeros.len(), rng, device)?,
            log_std: Var::from_tensor(&log_std).map_err(failed)?,
            deviations: Deviations::new(zeros),
        })
    }

    fn forward(&self, obs: &[f32]) -> Result<Tensor> {
        self.body.forward(Net::Online, obs, self.body.rows(obs)?)
    }

    fn set_deviations(&mut self, deviations: Deviations) -> Result<()> {
        let values = &deviations.log_std;
        let tensor = Tensor::from_slice(values, values.len(), &self.body.device).map_err(failed)?;
        self.log_std.set(&tensor).map_err(failed)?;
        self.deviations = deviations;
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
        self.set_deviations(deviations)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.body.save(state)?;
        self.deviations.save(state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        let deviations = self.deviations.load(state)?;
        self.body.load(state)?;
        self.set_deviations(deviations)
    }
}

impl on_policy::GaussianPolicy for Normal {
    fn log_std(&self) -> &[f32] {
        &self.deviations.log_std
    }

    fn means(&mut self, obs: &[f32], mean: &mut [f32]) -> Result<()> {
        let output = self.forward(obs)?;
        check::batch("means", mean, output.elem_count(), 1)?;
        mean.copy_from_slice(&values(&output).map_err(failed)?);
        Ok(())
    }

    fn descend(&mut self, obs: &[f32], step: Descent, grad: NormalGrad<'_>) -> Result<()> {
        let output = self.forward(obs)?;
        let mean = values(&output).map_err(failed)?;
        let mut grad_mean = vec![0.0; mean.len()];
        let mut grad_log_std = vec![0.0; self.deviations.log_std.len()];
        grad(
            on_policy::Normal { mean: &mean, log_std: &self.deviations.log_std },
            NormalGradient { mean: &mut grad_mean, log_std: &mut grad_log_std },
        )?;
        let loss = || {
            // A loss with these gradients, which are constants.
            let grad_mean = Tensor::from_vec(grad_mean, output.dims(), &self.body.device)?;
            let grad =
                Tensor::from_vec(grad_log_std, self.deviations.log_std.len(), &self.body.device)?;
            (output * grad_mean)?.sum_all()? + (self.log_std.as_tensor() * grad)?.sum_all()?
        };
        let variables = self.body.network.online().chain([&self.log_std]);
        let loss = with_penalty(loss().map_err(failed)?, variables, step.decay)?;
        let mut descend = || {
            let mut grads = loss.backward()?;
            let log_std = match grads.get(&self.log_std) {
                Some(grad) => values(grad)?,
                None => vec![0.0; self.deviations.log_std.len()],
            };
            let own: f64 = log_std.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
            let factor = factor(self.body.network.squares(&grads)? + own, step);
            self.body.network.scale(&mut grads, factor)?;
            self.body.network.step(&grads, step.lr)?;
            Ok((log_std, factor as f32))
        };
        let (log_std, factor) = descend().map_err(failed)?;
        let cut: Vec<f32> = log_std.iter().map(|grad| factor * grad).collect();
        let mut deviations = self.deviations.clone();
        deviations.step(&cut, step.lr, self.body.network.steps());
        self.set_deviations(deviations)
    }
}
