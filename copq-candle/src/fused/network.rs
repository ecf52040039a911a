//! One network with all that it has learned and its working memory.

use copq::{Net, Result, State};

use super::layout::Layout;
use super::panels::{Line, Panels};
use super::perceptron::{Perceptron, Scratch};
use super::{adam, passes};
use crate::learned::Learned;
use crate::shape::Shape;

/// A multilayer perceptron, its target, its optimiser and its scratch.
#[derive(Clone, Debug)]
pub(super) struct Network {
    layout: Layout,
    learned: Learned<Line>,
    grad: Vec<Line>,
    scratch: Scratch,
}

impl Network {
    /// A network that goes on from what was learned.
    pub fn new(shape: Shape, learned: &Learned) -> Self {
        let layout = Layout::new(shape);
        let grad = vec![Line::default(); layout.len()];
        Self { learned: learned.map(|flat| layout.pack(flat)), layout, grad, scratch: Scratch::default() }
    }

    /// Its layers.
    pub fn shape(&self) -> &Shape {
        self.layout.shape()
    }

    /// What it has learned.
    pub fn learned(&self) -> Learned {
        self.learned.map(|lines| self.layout.unpack(lines))
    }

    /// Replaces what it has learned; the layers must be the same.
    pub fn set_learned(&mut self, learned: &Learned) {
        self.learned = learned.map(|flat| self.layout.pack(flat));
    }

    /// Runs a batch through, and remembers what a backward pass needs.
    pub fn forward(&mut self, net: Net, input: &Panels, out: &mut [f32]) {
        let Self { layout, learned, scratch, .. } = self;
        let parameters = match net {
            Net::Online => &learned.online,
            Net::Target => &learned.target,
        };
        Perceptron { layout, parameters }.forward(input, scratch).get(0, out);
    }

    /// After an online [`Network::forward`] on the same input: backward from dL/dout and one optimiser step.
    pub fn learn(&mut self, input: &Panels, grad_out: &[f32], lr: f64) {
        let Self { layout, learned, grad, scratch } = self;
        Perceptron { layout, parameters: &learned.online }.backward(input, scratch, grad_out, grad);
        adam::step(learned, grad, lr);
    }

    /// After an online [`Network::forward`] on `rows` inputs: dL/d(their columns from `first` on).
    pub fn input_grad(&mut self, rows: usize, grad_out: &[f32], first: usize, out: &mut [f32]) {
        let Self { layout, learned, scratch, .. } = self;
        let online = Perceptron { layout, parameters: &learned.online };
        online.backward_to_input(scratch, rows, grad_out, first, out);
    }

    /// Polyak averaging of the target.
    pub fn track(&mut self, tau: f32) {
        passes::polyak(&mut self.learned.target, &self.learned.online, tau);
    }

    /// Writes what it has learned.
    pub fn save(&self, state: &mut State) {
        self.learned().save(self.shape(), state);
    }

    /// Restores what [`Network::save`] wrote.
    pub fn load(&mut self, state: &State) -> Result<()> {
        self.set_learned(&Learned::load(self.shape(), state)?);
        Ok(())
    }
}
