//! A critic of observations in the fast implementation.

use copq::on_policy::{self, Descent, ValueGrad};
use copq::{EnvSpec, Networks, Result, Rng, State};

use super::network::Network;
use super::panels::{PanelRow, Panels};
use super::passes::{self, room};
use super::workspace::Workspace;
use crate::check;
use crate::learned::Learned;
use crate::shape::Shape;

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
/// // Up everywhere.
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
    network: Network,
    input: Panels,
    workspace: Workspace,
    observation: usize,
    value: Vec<f32>,
    grad_value: Vec<f32>,
    grad: Vec<PanelRow>,
}

impl Value {
    /// A critic for an environment, with fresh weights drawn from `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<Self> {
        check::settings(spec, networks)?;
        let shape = Shape::new(spec.obs_len, &networks.hidden, 1);
        let learned = Learned::new(&shape, networks.init, rng);
        Ok(Self {
            network: Network::new(shape, networks, &learned),
            input: Panels::default(),
            workspace: Workspace::default(),
            observation: spec.obs_len,
            value: Vec::new(),
            grad_value: Vec::new(),
            grad: Vec::new(),
        })
    }
}

/// Adds the penalty's part to a network's gradient and cuts it to the largest norm; `more` is what
/// else counts for that, as a sum of squares. Returns what the whole gradient was multiplied by.
pub(super) fn prepare(
    network: &Network,
    grad: &mut [PanelRow],
    more: f64,
    Descent { decay, max_norm, .. }: Descent,
) -> f32 {
    if decay > 0.0 {
        passes::add(grad, network.online(), (2.0 * decay) as f32);
    }
    let norm = (passes::squares(grad) + more).sqrt();
    let factor = (max_norm / (norm + 1e-6)).min(1.0) as f32;
    if factor < 1.0 {
        passes::scale(grad, factor);
    }
    factor
}

impl on_policy::StateValue for Value {
    fn values(&mut self, obs: &[f32], value: &mut [f32]) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        check::batch("values", value, rows, 1)?;
        self.input.set(rows, &[obs]);
        self.network.values(copq::Net::Online, &self.input, false, value, &mut self.workspace);
        Ok(())
    }

    fn descend(&mut self, obs: &[f32], step: Descent, grad: ValueGrad<'_>) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        self.input.set(rows, &[obs]);
        let value = room(&mut self.value, rows);
        self.network.forward(&self.input, false, value, &mut self.workspace);
        let grad_value = room(&mut self.grad_value, rows);
        grad(value, grad_value)?;
        self.network.gradient(&self.input, grad_value, &mut self.grad, &mut self.workspace);
        prepare(&self.network, &mut self.grad, 0.0, step);
        self.network.descend(&self.grad, step.lr);
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.network.save(state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.network.load(state)
    }
}
