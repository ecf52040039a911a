//! Forward and backward through a multilayer perceptron, on slices.

use super::matmul::{Matrix, matmul};
use super::passes::{add_bias, add_bias_relu, mask_relu, sum_rows};
use crate::shape::{Layer, Shape};

/// One network's parameters, about to be used on a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Perceptron<'a> {
    /// Its layers.
    pub shape: &'a Shape,
    /// Weights and biases, laid out by the shape.
    pub parameters: &'a [f32],
    /// Rows of the batch.
    pub rows: usize,
}

impl Perceptron<'_> {
    /// Runs the batch (`rows x input`) through the network; keeps the hidden activations in `scratch`.
    pub fn forward(self, input: &[f32], scratch: &mut Scratch, out: &mut [f32]) {
        let last = self.shape.layers().len() - 1; // A Shape has at least one layer.
        scratch.hidden.resize_with(last, Vec::new);
        for (i, layer) in self.shape.layers().iter().enumerate() {
            let (below, here) = scratch.hidden.split_at_mut(i);
            let input = below.last().map_or(input, |h| &h[..self.rows * layer.input]);
            let out = if i == last { &mut *out } else { room(&mut here[0], self.rows * layer.output) };
            matmul(out, Matrix::new(input, self.rows, layer.input), self.weight(layer).t());
            let bias = &self.parameters[layer.bias()];
            if i == last { add_bias(out, bias) } else { add_bias_relu(out, bias) }
        }
    }

    /// After [`Perceptron::forward`] on the same input: dL/dparameters from dL/dout, written over `grad`.
    pub fn backward(self, input: &[f32], scratch: &mut Scratch, grad_out: &[f32], grad: &mut [f32]) {
        let (hidden, here, below) = scratch.begin(self, grad_out);
        for (i, layer) in self.shape.layers().iter().enumerate().rev() {
            let input = if i == 0 { input } else { &hidden[i - 1][..self.rows * layer.input] };
            let delta = self.delta(layer, here);
            matmul(&mut grad[layer.weight()], delta.t(), Matrix::new(input, self.rows, layer.input));
            sum_rows(&here[..self.rows * layer.output], &mut grad[layer.bias()]);
            if i > 0 {
                self.step_down(layer, here, input, below);
                std::mem::swap(here, below);
            }
        }
    }

    /// After [`Perceptron::forward`]: dL/d(input columns from `first` on) from dL/dout, without the parameters' gradient.
    pub fn backward_to_input(self, scratch: &mut Scratch, grad_out: &[f32], first: usize, out: &mut [f32]) {
        let (hidden, here, below) = scratch.begin(self, grad_out);
        for (i, layer) in self.shape.layers().iter().enumerate().skip(1).rev() {
            self.step_down(layer, here, &hidden[i - 1], below);
            std::mem::swap(here, below);
        }
        let layer = &self.shape.layers()[0];
        matmul(out, self.delta(layer, here), self.weight(layer).columns_from(first));
    }

    /// dL/d(output of the layer below, before its ReLU) from this layer's `delta` and the activation between them.
    fn step_down(self, layer: &Layer, delta: &[f32], activation: &[f32], below: &mut [f32]) {
        let below = &mut below[..self.rows * layer.input];
        matmul(below, self.delta(layer, delta), self.weight(layer));
        mask_relu(below, activation);
    }

    /// A layer's weight as an `output x input` matrix.
    fn weight(&self, layer: &Layer) -> Matrix<'_> {
        Matrix::new(&self.parameters[layer.weight()], layer.output, layer.input)
    }

    /// The beginning of a buffer as `rows x output`.
    fn delta<'b>(&self, layer: &Layer, buffer: &'b [f32]) -> Matrix<'b> {
        Matrix::new(&buffer[..self.rows * layer.output], self.rows, layer.output)
    }
}

/// Working memory for one network: it grows to the largest batch and is then reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Outputs of every hidden layer, after ReLU, from the last forward.
    hidden: Vec<Vec<f32>>,
    /// dL/d(a layer's output before its ReLU), and the same for the layer below.
    delta: [Vec<f32>; 2],
}

impl Scratch {
    /// The hidden activations, a delta buffer that begins with dL/dout, and another; both fit the widest layer.
    fn begin(&mut self, net: Perceptron<'_>, grad_out: &[f32]) -> (&[Vec<f32>], &mut Vec<f32>, &mut Vec<f32>) {
        let widest = net.shape.layers().iter().map(|layer| layer.output).max().unwrap_or(0);
        let [here, below] = &mut self.delta;
        room(below, net.rows * widest);
        room(here, net.rows * widest)[..grad_out.len()].copy_from_slice(grad_out);
        (&self.hidden, here, below)
    }
}

/// The first `len` values of a buffer that grows when it must.
pub(super) fn room(buffer: &mut Vec<f32>, len: usize) -> &mut [f32] {
    if buffer.len() < len {
        buffer.resize(len, 0.0);
    }
    &mut buffer[..len]
}
