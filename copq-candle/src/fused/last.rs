//! The last layer. It has few outputs, so inputs lie in its lanes. No lane is idle, and its weight
//! lies as the backward pass reads it.
//!
//! A map consists of panels of inputs with a line for every output and one of zeros, from which the
//! backward pass starts. The bias follows, with outputs in the lanes.

#[cfg(test)]
mod tests;

use pulp::{Arch, Simd};

use super::gradient::{Descent, Sink, Stored, sum, weights};
use super::panels::{PanelRow, Panels, WIDTH};
use super::tiles::{ByLanes, Kernel, array, vectors, vectors_mut};
use crate::shape::Layer;

/// Rows of a tile.
const HEIGHT: usize = 4;

/// Number of lines of a layer's map.
pub(super) fn lines(layer: &Layer) -> usize {
    weight_lines(layer.input, layer.output) + layer.output.div_ceil(WIDTH)
}

/// The lines of its weight: the map from outputs to inputs.
pub(super) fn back<'a>(layer: &Layer, map: &'a [PanelRow]) -> &'a [PanelRow] {
    &map[..weight_lines(layer.input, layer.output)]
}

fn weight_lines(inputs: usize, outputs: usize) -> usize {
    inputs.div_ceil(WIDTH) * (outputs + 1)
}

/// The line of a weight in a layer's map, and its place there. The bias counts as the input after
/// the last.
pub(super) fn place(layer: &Layer, output: usize, input: usize) -> (usize, usize) {
    if input == layer.input {
        (weight_lines(layer.input, layer.output) + output / WIDTH, output % WIDTH)
    } else {
        (input / WIDTH * (layer.output + 1) + output, input % WIDTH)
    }
}

/// `out = input * map + bias`, row after row.
///
/// Each lane adds up every sixteenth product by fused multiply-adds. Then halves of the lanes are
/// added until one is left, then the bias. The order is the same for vectors of any width.
pub(super) fn affine(input: &Panels, map: &[PanelRow], out: &mut [f32]) {
    let count = out.len() / input.rows();
    let (map, bias) = map.split_at(weight_lines(input.cols(), count));
    assert_eq!(bias.len(), count.div_ceil(WIDTH), "lines of a bias");
    let bias = bytemuck::cast_slice(bias);
    Arch::new().dispatch(ByLanes(Affine { input, map, bias, count, out }));
}

/// The map's gradient, laid out like the map, given that of its outputs. The lines of zeros are not
/// written.
pub(super) fn gradient(input: &Panels, right: &Panels, out: &mut [PanelRow]) {
    check(input, right, out.len());
    Arch::new().dispatch(ByLanes(Gradient { input, right, sink: Stored(out) }));
}

/// One step of a map along what [`gradient`] would write.
pub(super) fn descend(input: &Panels, right: &Panels, map: Descent<'_>) {
    check(input, right, map.online.len());
    Arch::new().dispatch(ByLanes(Gradient { input, right, sink: map }));
}

fn check(input: &Panels, right: &Panels, len: usize) {
    assert_eq!(input.rows(), right.rows(), "rows of a gradient");
    let lines = weight_lines(input.cols(), right.cols()) + right.cols().div_ceil(WIDTH);
    assert_eq!(len, lines, "lines of a gradient");
}

struct Affine<'a> {
    input: &'a Panels,
    map: &'a [PanelRow],
    bias: &'a [f32],
    count: usize,
    out: &'a mut [f32],
}

impl Kernel for Affine<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(mut self, simd: S) {
        let rows = self.input.rows();
        let whole = rows - rows % HEIGHT;
        for row in (0..whole).step_by(HEIGHT) {
            self.rows::<S, V, HEIGHT>(simd, row);
        }
        for row in whole..rows {
            self.rows::<S, V, 1>(simd, row);
        }
    }
}

impl Affine<'_> {
    /// Computes all outputs of `H` rows.
    #[inline(always)]
    fn rows<S: Simd, const V: usize, const H: usize>(&mut self, simd: S, row: usize) {
        let mut first = 0;
        while first < self.count {
            first += match self.count - first {
                3.. => self.tile::<S, V, H, 3>(simd, row, first),
                2 => self.tile::<S, V, H, 2>(simd, row, first),
                _ => self.tile::<S, V, H, 1>(simd, row, first),
            };
        }
    }

    #[inline(always)]
    fn tile<S: Simd, const V: usize, const H: usize, const U: usize>(
        &mut self,
        simd: S,
        row: usize,
        first: usize,
    ) -> usize {
        let rows = self.input.rows();
        let input = vectors::<S, V>(self.input.lines());
        let map = vectors::<S, V>(self.map);
        let mut sums = [[PanelRow::default(); U]; H];
        for v in 0..V {
            let mut part = [[simd.splat_f32s(0.0); U]; H];
            for (input, map) in input.chunks_exact(rows).zip(map.chunks_exact(self.count + 1)) {
                let input = &input[row..row + H];
                let map = &map[first..first + U];
                for (sums, input) in part.iter_mut().zip(input) {
                    for (sum, map) in sums.iter_mut().zip(map) {
                        *sum = simd.mul_add_f32s(input[v], map[v], *sum);
                    }
                }
            }
            for (to, from) in sums.as_flattened_mut().iter_mut().zip(part.as_flattened()) {
                vectors_mut::<S, V>(std::slice::from_mut(to))[0][v] = *from;
            }
        }
        for (out, sums) in self.out[row * self.count..].chunks_mut(self.count).zip(&sums) {
            for (output, sum) in (first..).zip(sums) {
                out[output] = total(&sum.0) + self.bias[output];
            }
        }
        U
    }
}

/// The sum of sixteen values, by halves.
#[inline(always)]
fn total(sums: &[f32; WIDTH]) -> f32 {
    let eight: [f32; 8] = array(|i| sums[i] + sums[i + 8]);
    let four: [f32; 4] = array(|i| eight[i] + eight[i + 4]);
    let two: [f32; 2] = array(|i| four[i] + four[i + 2]);
    two[0] + two[1]
}

struct Gradient<'a, T> {
    input: &'a Panels,
    right: &'a Panels,
    sink: T,
}

impl<T: Sink> Kernel for Gradient<'_, T> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(mut self, simd: S) {
        let (input, sink) = (self.input, &mut self.sink);
        weights::<S, V>(simd, self.right, input.lines(), input.cols(), sink);
        let bias = weight_lines(input.cols(), self.right.cols());
        let panels = vectors::<S, V>(self.right.lines()).chunks_exact(self.right.rows());
        for (line, panel) in (bias..).zip(panels) {
            sink.take::<S, V, 1>(simd, line, [sum(simd, panel)]);
        }
    }
}
