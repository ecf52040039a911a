//! What a pass works on, for one network after another.

use super::panels::{Line, Panels, WIDTH};
use super::product::{Finish, affine, gradient};
use super::transpose::transpose;
use crate::shape::Layer;

/// Buffers that grow to the largest layer and batch and are then reused. A thread's networks share one, so that little of
/// it leaves the cache.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    /// Every layer's outputs, where no backward pass will follow.
    outputs: Vec<Panels>,
    /// dL/d(outputs of the present layer, before their ReLU).
    delta: Panels,
    /// What becomes `delta` next.
    below: Panels,
    /// A layer's weight turned round.
    transposed: Panels,
    /// dL/d(a layer's parameters).
    grad: Panels,
}

impl Workspace {
    /// Buffers for the outputs of so many layers.
    pub fn outputs(&mut self, layers: usize) -> &mut [Panels] {
        if self.outputs.len() < layers {
            self.outputs.resize_with(layers, Panels::default);
        }
        &mut self.outputs[..layers]
    }

    /// Begins at a network's outputs with dL/doutputs.
    pub fn begin(&mut self, rows: usize, grad: &[f32]) {
        self.delta.set(rows, &[grad]);
    }

    /// dL/dparameters of the present layer, laid out as they are, given its inputs.
    pub fn gradient(&mut self, input: &Panels) -> &[Line] {
        gradient(input, &self.delta, self.grad.reshape(input.cols() + 1, self.delta.cols()));
        self.grad.lines()
    }

    /// Keeps the present layer's weight for the way down, for inputs from panel `first` on.
    pub fn turn(&mut self, layer: &Layer, map: &[Line], first: usize) {
        transpose(layer, map, first, &mut self.transposed);
    }

    /// After [`Workspace::turn`]: goes down to the layer that put out `activation`.
    pub fn step_down(&mut self, activation: &Panels) {
        affine(&self.delta, self.transposed.lines(), activation.cols(), Finish::Mask(activation), &mut self.below);
        std::mem::swap(&mut self.delta, &mut self.below);
    }

    /// After [`Workspace::begin`] on the way through the first layer: dL/d(its inputs' columns from `first` on).
    pub fn step_out(&mut self, layer: &Layer, map: &[Line], first: usize, out: &mut [f32]) {
        let panel = first / WIDTH;
        self.turn(layer, map, panel);
        affine(&self.delta, self.transposed.lines(), layer.input - panel * WIDTH, Finish::Keep, &mut self.below);
        self.below.get(first % WIDTH, out);
    }
}
