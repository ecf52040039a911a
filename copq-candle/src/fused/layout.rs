//! Where a network's parameters lie: each layer's weight and bias as one map of
//! [`affine`](super::product::affine), the last layer's as one of [`last`](super::last).

use std::ops::Range;

use super::last;
use super::panels::{PanelRow, WIDTH};
use crate::shape::{Layer, Shape};

/// A network's layers, one after another in lines: panels of a layer's outputs, with a line for
/// every input and one more, the bias; for the last layer see [`last`]. What a panel has too many is zero
/// and stays so: its gradient is.
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
            end += if i + 1 == count { last::lines(layer) } else { lines(layer) };
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

    /// A layer's map with nothing to start from.
    pub fn without_bias(&self, layer: usize, map: &[PanelRow]) -> Vec<PanelRow> {
        let is_last = layer == self.maps.len() - 1;
        let layer = &self.shape.layers()[layer];
        let mut map = map.to_vec();
        for output in 0..layer.output {
            let (line, place) =
                if is_last { last::bias(layer, output) } else { bias(layer, output) };
            map[line].0[place] = 0.0;
        }
        map
    }

    /// Lines from a flat buffer laid out by the shape.
    pub fn pack(&self, flat: &[f32]) -> Vec<PanelRow> {
        let mut lines = vec![PanelRow::default(); self.len()];
        self.places(|at, line, place| lines[line].0[place] = flat[at]);
        lines
    }

    /// The flat buffer that [`Layout::pack`] would make these lines of.
    pub fn unpack(&self, lines: &[PanelRow]) -> Vec<f32> {
        let mut flat = vec![0.0; self.shape.len()];
        self.places(|at, line, place| flat[at] = lines[line].0[place]);
        flat
    }

    /// Calls with every parameter's position in the flat buffer, its line, and its place there.
    fn places(&self, mut visit: impl FnMut(usize, usize, usize)) {
        let last = self.maps.len() - 1; // There is at least one layer.
        for (i, (layer, map)) in self.maps().enumerate() {
            let is_last = i == last;
            for output in 0..layer.output {
                for input in 0..layer.input {
                    let of = if is_last { last::weight } else { weight };
                    let (line, place) = of(layer, output, input);
                    let at = layer.weight().start + output * layer.input + input;
                    visit(at, map.start + line, place);
                }
                let of = if is_last { last::bias } else { bias };
                let (line, place) = of(layer, output);
                visit(layer.bias().start + output, map.start + line, place);
            }
        }
    }
}

/// Lines of a layer's map that is not the last.
fn lines(layer: &Layer) -> usize {
    layer.output.div_ceil(WIDTH) * (layer.input + 1)
}

/// The line of its map, and the place there, of a weight.
fn weight(layer: &Layer, output: usize, input: usize) -> (usize, usize) {
    (output / WIDTH * (layer.input + 1) + input, output % WIDTH)
}

/// The same of a bias.
fn bias(layer: &Layer, output: usize) -> (usize, usize) {
    weight(layer, output, layer.input)
}
