//! Where a network's parameters lie: each layer's weight and bias as one map of
//! [`affine`](super::product::affine).

use std::ops::Range;

use super::panels::{PanelRow, WIDTH};
use crate::shape::{Layer, Shape};

/// A network's layers, one after another in lines: panels of a layer's outputs, with a line for
/// every input and one more, the bias. What a panel has too many is zero and stays so: its gradient
/// is.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    shape: Shape,
    maps: Vec<Range<usize>>,
}

impl Layout {
    pub fn new(shape: Shape) -> Self {
        let mut end = 0;
        let map = |layer: &Layer| {
            let start = end;
            end += layer.output.div_ceil(WIDTH) * (layer.input + 1);
            start..end
        };
        Self { maps: shape.layers().iter().map(map).collect(), shape }
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
        for (layer, map) in self.maps() {
            for output in 0..layer.output {
                let start = map.start + output / WIDTH * (layer.input + 1);
                for input in 0..layer.input {
                    visit(
                        layer.weight().start + output * layer.input + input,
                        start + input,
                        output % WIDTH,
                    );
                }
                visit(layer.bias().start + output, start + layer.input, output % WIDTH);
            }
        }
    }
}
