//! Where a network's parameters lie: each layer's weight and bias as one map of
//! [`affine`](super::product::affine), the last layer's as one of [`last`](super::last).

use std::ops::Range;

use super::last;
use super::panels::{PanelRow, WIDTH};
use crate::shape::{Layer, Shape};

/// A network's layers, one after another in lines. A layer is panels of its outputs, with a line
/// for every input and one for the bias; for the last layer see [`last`]. Surplus places in a panel
/// are zero and stay so, because their gradient is zero.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    shape: Shape,
    maps: Vec<Range<usize>>,
}

impl Layout {
    pub fn new(shape: Shape) -> Self {
        let mut end = 0;
        let count = shape.layers().len();
        let map = |(i, layer): (usize, &Layer)| {
            let start = end;
            end += if i + 1 == count {
                last::lines(layer)
            } else {
                layer.output.div_ceil(WIDTH) * (layer.input + 1)
            };
            start..end
        };
        Self { maps: shape.layers().iter().enumerate().map(map).collect(), shape }
    }

    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The layers and their lines, first to last; there is at least one.
    pub fn maps(
        &self,
    ) -> impl DoubleEndedIterator<Item = (&Layer, Range<usize>)> + ExactSizeIterator {
        self.shape.layers().iter().zip(self.maps.iter().cloned())
    }

    /// How many lines there are.
    pub fn len(&self) -> usize {
        self.maps.last().map_or(0, |last| last.end)
    }

    /// Where the last layer's map lies.
    pub fn last(&self) -> Range<usize> {
        self.maps.last().cloned().unwrap_or_default()
    }

    /// A layer's map with a bias of zero.
    pub fn without_bias(&self, i: usize, parameters: &[PanelRow]) -> Vec<PanelRow> {
        let layer = &self.shape.layers()[i];
        let start = self.maps[i].start;
        let mut map = parameters[self.maps[i].clone()].to_vec();
        for output in 0..layer.output {
            let (line, place) = self.place(i, output, layer.input);
            map[line - start].0[place] = 0.0;
        }
        map
    }

    /// Lines from a flat buffer laid out by the shape.
    pub fn pack(&self, flat: &[f32]) -> Vec<PanelRow> {
        let mut lines = vec![PanelRow::default(); self.len()];
        self.places(|at, line, place| lines[line].0[place] = flat[at]);
        lines
    }

    /// The flat buffer that [`Layout::pack`] would turn into these lines.
    pub fn unpack(&self, lines: &[PanelRow]) -> Vec<f32> {
        let mut flat = vec![0.0; self.shape.len()];
        self.places(|at, line, place| flat[at] = lines[line].0[place]);
        flat
    }

    /// Calls `visit` with every parameter's position in the flat buffer, its line, and its place
    /// there.
    fn places(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for (i, layer) in self.shape.layers().iter().enumerate() {
            for output in 0..layer.output {
                let weight = layer.weight().start + output * layer.input;
                for input in 0..layer.input {
                    let (line, place) = self.place(i, output, input);
                    visit(weight + input, line, place);
                }
                let (line, place) = self.place(i, output, layer.input);
                visit(layer.bias().start + output, line, place);
            }
        }
    }

    /// The line of a layer's weight, and its place there. The bias counts as the input after the
    /// last.
    fn place(&self, i: usize, output: usize, input: usize) -> (usize, usize) {
        let layer = &self.shape.layers()[i];
        let (line, place) = if i + 1 == self.maps.len() {
            last::place(layer, output, input)
        } else {
            (output / WIDTH * (layer.input + 1) + input, output % WIDTH)
        };
        (self.maps[i].start + line, place)
    }
}
