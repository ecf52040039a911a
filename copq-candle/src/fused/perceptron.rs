//! Forward and backward through a multilayer perceptron, on slices.

use super::matmul::{Matrix, matmul};
use super::passes::{add_bias, add_bias_relu, mask_relu, sum_rows};
use crate::shape::{Layer, Shape};

/// Working memory for one network: it grows to the largest batch and is then reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Outputs of every hidden layer, after ReLU, from the last forward.
    hidden: Vec<Vec<f32>>,
    /// dL/d(a layer's output before its ReLU), and the same for the layer below.
    delta: [Vec<f32>; 2],
}

impl Scratch {
    /// Hidden activations, and a delta buffer of the widest layer's size that begins with dL/dout, and one more.
    fn begin(&mut self, shape: &Shape, rows: usize, grad_out: &[f32]) -> (&[Vec<f32>], &mut Vec<f32>, &mut Vec<f32>) {
        let widest = shape.layers().iter().map(|layer| layer.output).max().unwrap_or(0);
        let [here, below] = &mut self.delta;
        room(below, rows * widest);
        room(here, rows * widest)[..grad_out.len()].copy_from_slice(grad_out);
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

/// A layer's weight as an `output x input` matrix.
fn weight<'a>(layer: &Layer, parameters: &'a [f32]) -> Matrix<'a> {
    Matrix::new(&parameters[layer.weight()], layer.output, layer.input)
}

/// Runs `rows` inputs through the network; keeps the hidden activations in `scratch`.
pub(super) fn forward(
    shape: &Shape,
    parameters: &[f32],
    input: &[f32],
    rows: usize,
    scratch: &mut Scratch,
    out: &mut [f32],
) {
    let last = shape.layers().len() - 1; // A Shape has at least one layer.
    scratch.hidden.resize_with(last, Vec::new);
    for (i, layer) in shape.layers().iter().enumerate() {
        let (below, here) = scratch.hidden.split_at_mut(i);
        let input = below.last().map_or(input, |h| &h[..rows * layer.input]);
        let input = Matrix::new(input, rows, layer.input);
        let bias = &parameters[layer.bias()];
        let out = if i == last { &mut *out } else { room(&mut here[0], rows * layer.output) };
        matmul(out, input, weight(layer, parameters).t());
        if i == last { add_bias(out, bias) } else { add_bias_relu(out, bias) }
    }
}

/// After [`forward`] on the same input: dL/dparameters from dL/dout, written over `grad`.
pub(super) fn backward(
    shape: &Shape,
    parameters: &[f32],
    input: &[f32],
    rows: usize,
    scratch: &mut Scratch,
    grad_out: &[f32],
    grad: &mut [f32],
) {
    let (hidden, here, below) = scratch.begin(shape, rows, grad_out);
    for (i, layer) in shape.layers().iter().enumerate().rev() {
        let delta = Matrix::new(&here[..rows * layer.output], rows, layer.output);
        let input = if i == 0 { input } else { &hidden[i - 1][..rows * layer.input] };
        matmul(&mut grad[layer.weight()], delta.t(), Matrix::new(input, rows, layer.input));
        sum_rows(&here[..rows * layer.output], &mut grad[layer.bias()]);
        if i > 0 {
            step_down(layer, parameters, rows, here, input, below);
            std::mem::swap(here, below);
        }
    }
}

/// After [`forward`]: dL/d(input columns from `first` on) from dL/dout, without the parameters' gradient.
pub(super) fn backward_to_input(
    shape: &Shape,
    parameters: &[f32],
    rows: usize,
    scratch: &mut Scratch,
    grad_out: &[f32],
    first: usize,
    out: &mut [f32],
) {
    let (hidden, here, below) = scratch.begin(shape, rows, grad_out);
    for (i, layer) in shape.layers().iter().enumerate().skip(1).rev() {
        step_down(layer, parameters, rows, here, &hidden[i - 1][..rows * layer.input], below);
        std::mem::swap(here, below);
    }
    let layer = &shape.layers()[0];
    let delta = Matrix::new(&here[..rows * layer.output], rows, layer.output);
    matmul(out, delta, weight(layer, parameters).columns_from(first));
}

/// dL/d(output of the layer below, before its ReLU) from this layer's `delta` and the activation between them.
fn step_down(layer: &Layer, parameters: &[f32], rows: usize, delta: &[f32], activation: &[f32], below: &mut Vec<f32>) {
    let below = room(below, rows * layer.input);
    let delta = Matrix::new(&delta[..rows * layer.output], rows, layer.output);
    matmul(below, delta, weight(layer, parameters));
    mask_relu(below, activation);
}
