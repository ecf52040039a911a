//! A critic of observations, readable.

use candle_core::{Device, Tensor, Var};
use copq::on_policy::{self, Descent, ValueGrad};
use copq::{EnvSpec, Net, Networks, Result, Rng, State};

use super::body::Body;
use super::{failed, loss_of, values};
use crate::check;

/// A critic for on-policy learning: observation -> hidden layers -> one number. It is
/// [`fused::Value`](crate::fused::Value) by autograd, on any device.
///
/// ```
/// use copq::on_policy::StateValue as _;
/// use copq::{EnvSpec, Networks, Rng, Stream};
/// use copq_candle::{Device, plain::Value};
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let rng = &mut Rng::new(0, Stream::Init);
/// let mut critic = Value::new(&spec, &Networks::default(), rng, &Device::Cpu)?;
/// let mut value = [0.0];
/// critic.values(&[0.1, 0.2], &mut value)?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Value(Body);

impl Value {
    /// A critic for an environment, with fresh weights drawn from `rng`.
    pub fn new(
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        Ok(Self(Body::new(None, spec, networks, 1, rng, device)?))
    }

    fn forward(&self, obs: &[f32]) -> Result<Tensor> {
        self.0.forward(Net::Online, obs, self.0.rows(obs)?)
    }
}

/// What cuts a gradient of so large a sum of squares.
pub(super) fn factor(squares: f64, step: Descent) -> f64 {
    (step.max_norm / (squares.sqrt() + 1e-6)).min(1.0)
}

/// A loss with the penalty on these variables.
pub(super) fn with_penalty<'a>(
    loss: Tensor,
    variables: impl Iterator<Item = &'a Var>,
    decay: f64,
) -> Result<Tensor> {
    let add = |loss: Tensor, variable: &Var| loss + (variable.sqr()?.sum_all()? * decay)?;
    variables.into_iter().try_fold(loss, add).map_err(failed)
}

impl on_policy::StateValue for Value {
    fn values(&mut self, obs: &[f32], value: &mut [f32]) -> Result<()> {
        let output = self.forward(obs)?;
        check::batch("values", value, output.elem_count(), 1)?;
        value.copy_from_slice(&values(&output).map_err(failed)?);
        Ok(())
    }

    fn descend(&mut self, obs: &[f32], step: Descent, grad: ValueGrad<'_>) -> Result<()> {
        let loss = loss_of(&self.forward(obs)?, grad)?;
        let loss = with_penalty(loss, self.0.network.online(), step.decay)?;
        let mut descend = || {
            let mut grads = loss.backward()?;
            let factor = factor(self.0.network.squares(&grads)?, step);
            self.0.network.scale(&mut grads, factor)?;
            self.0.network.step(&grads, step.lr)
        };
        descend().map_err(failed)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.0.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.0.load(state)
    }
}
