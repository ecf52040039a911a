//! A deterministic actor in the fast implementation.

use std::path::Path;

use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::network::Network;
use super::passes::{tanh, tanh_backward};
use super::perceptron::room;
use crate::learned::Learned;
use crate::shape::Shape;
use crate::{check, weights};

/// TD3's policy: observation -> hidden layers with ReLU -> tanh. It needs no noise and has no log-probability.
#[derive(Debug)]
pub struct Deterministic {
    network: Network,
    observation: usize,
    action: usize,
    lr: f64,
    output: Vec<f32>,
    grad: Vec<f32>,
}

impl Deterministic {
    /// An actor for an environment, with fresh weights drawn from `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<Self> {
        check::settings(spec, networks)?;
        let shape = Shape::actor(spec, networks);
        let learned = Learned::new(&shape, rng);
        Ok(Self {
            network: Network::new(shape, learned),
            observation: spec.observation,
            action: spec.action(),
            lr: networks.actor_lr,
            output: Vec::new(),
            grad: Vec::new(),
        })
    }

    /// Writes the online parameters to a safetensors file: `actor.layer.0.weight` (`output x input`) and so on.
    pub fn save_safetensors(&self, path: impl AsRef<Path>) -> Result<()> {
        let named = [(weights::actor_prefix(), self.network.learned().online.as_slice())];
        weights::save(path.as_ref(), &named, self.network.shape())
    }

    /// Starts from a safetensors file's parameters: the target becomes equal to them and the optimiser begins anew.
    pub fn load_safetensors(&mut self, path: impl AsRef<Path>) -> Result<()> {
        let online = weights::load(path.as_ref(), &[weights::actor_prefix()], self.network.shape())?;
        online.into_iter().for_each(|online| self.network.set_learned(Learned::from_online(online)));
        Ok(())
    }
}

impl Actor for Deterministic {
    fn action(&self) -> usize {
        self.action
    }

    fn noise(&self) -> usize {
        0
    }

    fn sample(&mut self, net: Net, obs: &[f32], noise: &[f32], action: &mut [f32], log_prob: &mut [f32]) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        check::deterministic(noise, log_prob)?;
        check::batch("actions", action, rows, self.action)?;
        self.network.forward(net, obs, rows, action);
        tanh(action);
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = check::rows(obs, self.observation)?;
        check::deterministic(noise, &[])?;
        let len = rows * self.action;
        let (action, dl) = (room(&mut self.output, len), room(&mut self.grad, len));
        self.network.forward(Net::Online, obs, rows, action);
        tanh(action);
        grad(Sample { action, log_prob: &[] }, SampleGrad { action: dl, log_prob: &mut [] })?;
        tanh_backward(dl, action);
        self.network.learn(obs, rows, dl, self.lr);
        Ok(())
    }

    fn noise_grad(&mut self, _obs: &[f32], noise: &[f32], _grad_action: &[f32], out: &mut [f32]) -> Result<()> {
        check::deterministic(noise, out)
    }

    fn track(&mut self, tau: f32) -> Result<()> {
        check::tau(tau)?;
        self.network.track(tau);
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
