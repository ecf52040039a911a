//! The layers of a multilayer perceptron and where each one's numbers lie in a flat buffer.

use std::ops::Range;

/// One linear layer: weight `output x input` row-major (PyTorch's layout), then the bias, in a flat
/// buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layer {
    /// Number of inputs.
    pub input: usize,
    /// Number of outputs.
    pub output: usize,
    start: usize,
}

impl Layer {
    /// Where the weight lies.
    pub fn weight(&self) -> Range<usize> {
        self.start..self.start + self.input * self.output
    }

    /// Where the bias lies.
    pub fn bias(&self) -> Range<usize> {
        let start = self.weight().end;
        start..start + self.output
    }
}

/// One array of a network's parameters: its name, its dimensions, and where it lies in the flat
/// buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Array {
    pub name: String,
    pub dims: Vec<usize>,
    pub range: Range<usize>,
}

/// A multilayer perceptron's layers in order, packed one after another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    layers: Vec<Layer>,
}

impl Shape {
    /// Layers of these widths, `input` first and `output` last.
    pub fn new(input: usize, hidden: &[usize], output: usize) -> Self {
        let mut input = input;
        let mut start = 0;
        let mut layers = Vec::with_capacity(hidden.len() + 1);
        for &output in hidden.iter().chain([&output]) {
            let layer = Layer { input, output, start };
            (input, start) = (output, layer.bias().end);
            layers.push(layer);
        }
        Self { layers }
    }

    /// The layers, first to last; there is at least one.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Length of a flat buffer of parameters.
    pub fn len(&self) -> usize {
        self.layers.last().map_or(0, |last| last.bias().end)
    }

    /// Every array in the flat buffer's order: `layer.0.weight` (`output x input`),
    /// `layer.0.bias`, `layer.1.weight` and so on.
    pub fn arrays(&self) -> Vec<Array> {
        let mut arrays = Vec::with_capacity(2 * self.layers.len());
        for (i, layer) in self.layers.iter().enumerate() {
            arrays.push(Array {
                name: format!("layer.{i}.weight"),
                dims: vec![layer.output, layer.input],
                range: layer.weight(),
            });
            arrays.push(Array {
                name: format!("layer.{i}.bias"),
                dims: vec![layer.output],
                range: layer.bias(),
            });
        }
        arrays
    }
}
