//! Forward and backward through a multilayer perceptron.

use super::layout::Layout;
use super::panels::{Line, Panels, WIDTH};
use super::product::{Finish, affine, gradient};
use super::transpose::transpose;
use crate::shape::Layer;

/// One network's parameters, about to be used on a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Perceptron<'a> {
    /// Its layers.
    pub layout: &'a Layout,
    /// Weights and biases.
    pub parameters: &'a [Line],
}

impl Perceptron<'_> {
    /// Runs a batch through the network and returns the outputs; keeps what a backward pass needs in `scratch`.
    pub fn forward<'s>(self, input: &Panels, scratch: &'s mut Scratch) -> &'s Panels {
        let last = self.layout.maps().len() - 1; // A layout has at least one layer.
        scratch.outputs.resize_with(last + 1, Panels::default);
        for (i, (layer, map)) in self.layout.maps().enumerate() {
            let (below, here) = scratch.outputs.split_at_mut(i);
            let finish = if i == last { Finish::Keep } else { Finish::Relu };
            affine(below.last().unwrap_or(input), &self.parameters[map], layer.output, finish, &mut here[0]);
        }
        &scratch.outputs[last]
    }

    /// After [`Perceptron::forward`] on the same input: dL/dparameters from dL/doutputs, written over `grad`.
    pub fn backward(self, input: &Panels, scratch: &mut Scratch, grad_out: &[f32], grad: &mut [Line]) {
        scratch.delta.set(input.rows(), &[grad_out]);
        for (i, (layer, map)) in self.layout.maps().enumerate().rev() {
            let input = if i == 0 { input } else { &scratch.outputs[i - 1] };
            gradient(input, &scratch.delta, &mut grad[map.clone()]);
            if i > 0 {
                scratch.step_down(i, layer, &self.parameters[map]);
            }
        }
    }

    /// After [`Perceptron::forward`] on `rows` inputs: dL/d(their columns from `first` on) from dL/doutputs, without the
    /// parameters' gradient.
    pub fn backward_to_input(
        self,
        scratch: &mut Scratch,
        rows: usize,
        grad_out: &[f32],
        first: usize,
        out: &mut [f32],
    ) {
        scratch.delta.set(rows, &[grad_out]);
        for (i, (layer, map)) in self.layout.maps().enumerate().rev() {
            if i > 0 {
                scratch.step_down(i, layer, &self.parameters[map]);
            } else {
                scratch.step_out(layer, &self.parameters[map], first, out);
            }
        }
    }
}

/// Working memory for one network: it grows to the largest batch and is then reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Every layer's outputs from the last forward pass, the hidden ones after ReLU.
    outputs: Vec<Panels>,
    /// dL/d(a layer's outputs before their ReLU).
    delta: Panels,
    /// What becomes `delta` next.
    below: Panels,
    transposed: Vec<Line>,
}

impl Scratch {
    /// Goes from layer `i` > 0 to the one below.
    fn step_down(&mut self, i: usize, layer: &Layer, map: &[Line]) {
        transpose(layer, map, 0, &mut self.transposed);
        let mask = Finish::Mask(&self.outputs[i - 1]);
        affine(&self.delta, &self.transposed, layer.input, mask, &mut self.below);
        std::mem::swap(&mut self.delta, &mut self.below);
    }

    /// Goes from the first layer to the inputs' columns from `first` on.
    fn step_out(&mut self, layer: &Layer, map: &[Line], first: usize, out: &mut [f32]) {
        let panel = first / WIDTH;
        transpose(layer, map, panel, &mut self.transposed);
        affine(&self.delta, &self.transposed, layer.input - panel * WIDTH, Finish::Keep, &mut self.below);
        self.below.get(first % WIDTH, out);
    }
}

/// The first `len` values of a buffer that grows when it must.
pub(super) fn room(buffer: &mut Vec<f32>, len: usize) -> &mut [f32] {
    if buffer.len() < len {
        buffer.resize(len, 0.0);
    }
    &mut buffer[..len]
}
