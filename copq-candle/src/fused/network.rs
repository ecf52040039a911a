//! One network with all that it has learned and its working memory.

use copq::{Net, Result, State};

use super::perceptron::{Perceptron, Scratch};
use super::{adam, passes};
use crate::learned::Learned;
use crate::shape::Shape;

/// A multilayer perceptron, its target, its optimiser and its scratch.
#[derive(Clone, Debug)]
pub(super) struct Network {
    shape: Shape,
    learned: Learned,
    grad: Vec<f32>,
    scratch: Scratch,
}

impl Network {
    /// A network that goes on from what was learned.
    pub fn new(shape: Shape, learned: Learned) -> Self {
        Self { grad: vec![0.0; shape.len()], scratch: Scratch::default(), shape, learned }
    }

    /// Its layers.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// What it has learned.
    pub fn learned(&self) -> &Learned {
        &self.learned
    }

    /// Replaces what it has learned; the layers must be the same.
    pub fn set_learned(&mut self, learned: Learned) {
        self.learned = learned;
    }

    /// Runs `rows` inputs through, and remembers what a backward pass needs.
    pub fn forward(&mut self, net: Net, input: &[f32], rows: usize, out: &mut [f32]) {
        let parameters = match net {
            Net::Online => &self.learned.online,
            Net::Target => &self.learned.target,
        };
        Perceptron { shape: &self.shape, parameters, rows }.forward(input, &mut self.scratch, out);
    }

    /// After an online [`Network::forward`] on the same input: backward from dL/dout and one optimiser step.
    pub fn learn(&mut self, input: &[f32], rows: usize, grad_out: &[f32], lr: f64) {
        let Self { shape, learned, grad, scratch } = self;
        Perceptron { shape, parameters: &learned.online, rows }.backward(input, scratch, grad_out, grad);
        adam::step(learned, grad, lr);
    }

    /// After an online [`Network::forward`]: dL/d(input columns from `first` on).
    pub fn input_grad(&mut self, rows: usize, grad_out: &[f32], first: usize, out: &mut [f32]) {
        let Self { shape, learned, scratch, .. } = self;
        let online = Perceptron { shape, parameters: &learned.online, rows };
        online.backward_to_input(scratch, grad_out, first, out);
    }

    /// Polyak averaging of the target.
    pub fn track(&mut self, tau: f32) {
        passes::polyak(&mut self.learned.target, &self.learned.online, tau);
    }

    /// Writes what it has learned.
    pub fn save(&self, state: &mut State) {
        self.learned.save(&self.shape, state);
    }

    /// Restores what [`Network::save`] wrote.
    pub fn load(&mut self, state: &State) -> Result<()> {
        self.learned = Learned::load(&self.shape, state)?;
        Ok(())
    }
}
