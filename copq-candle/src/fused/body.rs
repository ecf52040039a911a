//! The common part of actors and of critics of observations alone: a network that reads
//! observations, and its optimiser.

use copq::on_policy::Descent;
use copq::{EnvSpec, Net, Networks, Result, Rng, State};

use super::network::Network;
use super::panels::{PanelRow, Panels};
use super::passes;
use super::workspace::Workspace;
use crate::check;
use crate::learned::Learned;
use crate::shape::Shape;

/// A network from observations to outputs that its owner interprets.
#[derive(Debug)]
pub(super) struct Body {
    pub network: Network,
    /// The last observations.
    pub input: Panels,
    pub workspace: Workspace,
    observation: usize,
    /// Components of an action.
    pub action: usize,
    lr: f64,
}

impl Body {
    /// A network with `output` outputs and fresh weights drawn from `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, output: usize, rng: &mut Rng) -> Result<Self> {
        check::settings(spec, networks)?;
        let shape = Shape::new(spec.obs_len, &networks.hidden, output);
        let learned = Learned::new(&shape, networks.init, rng);
        Ok(Self {
            network: Network::new(shape, networks, &learned),
            input: Panels::default(),
            workspace: Workspace::default(),
            observation: spec.obs_len,
            action: spec.action_len(),
            lr: networks.actor_lr,
        })
    }

    /// Spreads large products over this many threads.
    pub fn threads(mut self, threads: usize) -> Result<Self> {
        self.workspace = Workspace::shared(threads)?;
        Ok(self)
    }

    /// The number of rows in a batch of observations.
    pub fn rows(&self, obs: &[f32]) -> Result<usize> {
        check::rows(obs, self.observation)
    }

    /// Runs a batch of observations through the network.
    pub fn values(&mut self, net: Net, obs: &[f32], rows: usize, out: &mut [f32]) {
        self.input.set(rows, &[obs]);
        self.network.values(net, &self.input, false, out, &mut self.workspace);
    }

    /// Runs a batch of observations through the online network, and remembers what a backward pass
    /// needs.
    pub fn forward(&mut self, obs: &[f32], rows: usize, out: &mut [f32]) {
        self.input.set(rows, &[obs]);
        self.network.forward(&self.input, false, out, &mut self.workspace);
    }

    /// After [`Body::forward`]: backward from dL/dout and one optimiser step. The target stays,
    /// because it may follow more often.
    pub fn learn(&mut self, grad_out: &[f32]) {
        self.network.learn(&self.input, grad_out, self.lr, 0.0, &mut self.workspace);
    }

    /// After [`Body::forward`]: the parameters' gradient, from dL/dout.
    pub fn gradient(&mut self, grad_out: &[f32], grad: &mut Vec<PanelRow>) {
        self.network.gradient(&self.input, grad_out, grad, &mut self.workspace);
    }

    /// One optimiser step down a gradient, after adding the penalty's part and clipping to the
    /// largest norm. `more` is the sum of squares of whatever else counts towards the norm. Returns
    /// the factor by which the whole gradient was scaled.
    pub fn descend(&mut self, grad: &mut [PanelRow], more: f64, step: Descent) -> f32 {
        let Descent { lr, decay, max_norm } = step;
        if decay > 0.0 {
            passes::add(grad, self.network.online(), (2.0 * decay) as f32);
        }
        let norm = (passes::squares(grad) + more).sqrt();
        let factor = (max_norm / (norm + 1e-6)).min(1.0) as f32;
        if factor < 1.0 {
            passes::scale(grad, factor);
        }
        self.network.descend(grad, lr);
        factor
    }

    pub fn update_target(&mut self, tau: f32) -> Result<()> {
        check::tau(tau)?;
        self.network.update_target(tau);
        Ok(())
    }

    pub fn export(&self, state: &mut State) -> Result<()> {
        let arrays = self.network.shape().arrays();
        Learned::export(&self.network.learned().online, &arrays, state);
        Ok(())
    }

    pub fn import(&mut self, state: &State) -> Result<()> {
        let online = Learned::import(&self.network.shape().arrays(), state)?;
        self.network.set_learned(&Learned::from_online(online));
        Ok(())
    }

    pub fn save(&self, state: &mut State) -> Result<()> {
        self.network.save(state);
        Ok(())
    }

    pub fn load(&mut self, state: &State) -> Result<()> {
        self.network.load(state)
    }
}
