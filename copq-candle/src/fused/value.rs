//! A critic of observations in the fast implementation.

use copq::on_policy::{self, Descent, ValueGrad};
use copq::{EnvSpec, Net, Networks, Result, Rng, State};

use super::body::Body;
use super::panels::PanelRow;
use super::passes::room;
use crate::check;

/// A critic for on-policy learning: observation -> hidden layers -> one number.
///
/// ```
/// use copq::on_policy::{Descent, StateValue as _};
/// use copq::{Activation, EnvSpec, Networks, Rng, Stream};
/// use copq_candle::fused::Value;
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let networks = Networks { activation: Activation::Tanh, ..Networks::default() };
/// let mut critic = Value::new(&spec, &networks, &mut Rng::new(0, Stream::Init))?;
///
/// // Raise its values everywhere.
/// let obs = [0.1, 0.2];
/// let mut values = [[0.0], [0.0]];
/// critic.values(&obs, &mut values[0])?;
/// let step = Descent { lr: 1e-3, decay: 0.0, max_norm: 40.0 };
/// critic.descend(&obs, step, &mut |_, grad| {
///     grad.fill(-1.0);
///     Ok(())
/// })?;
/// critic.values(&obs, &mut values[1])?;
/// assert!(values[1] > values[0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Value {
    body: Body,
    /// For a batch: values, their gradient, and that of the network's parameters.
    value: Vec<f32>,
    grad_value: Vec<f32>,
    grad: Vec<PanelRow>,
}

impl Value {
    /// A critic for an environment, with fresh weights drawn from `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<Self> {
        networks.check_f32("an on-policy network")?;
        let body = Body::new(spec, networks, 1, rng)?;
        Ok(Self { body, value: Vec::new(), grad_value: Vec::new(), grad: Vec::new() })
    }
}

impl on_policy::StateValue for Value {
    fn values(&mut self, obs: &[f32], value: &mut [f32]) -> Result<()> {
        let rows = self.body.rows(obs)?;
        check::batch("values", value, rows, 1)?;
        self.body.values(Net::Online, obs, rows, value);
        Ok(())
    }

    fn descend(&mut self, obs: &[f32], step: Descent, grad: ValueGrad<'_>) -> Result<()> {
        let rows = self.body.rows(obs)?;
        let value = room(&mut self.value, rows);
        self.body.forward(obs, rows, value);
        let grad_value = room(&mut self.grad_value, rows);
        grad(value, grad_value)?;
        self.body.gradient(grad_value, &mut self.grad);
        self.body.descend(&mut self.grad, 0.0, step);
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.body.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.body.load(state)
    }
}
