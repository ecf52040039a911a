//! A layer's weight transposed, for the backward pass.

use pulp::{Arch, Simd, WithSimd};

use super::panels::{PanelRow, Panels, WIDTH};
use crate::shape::Layer;

/// Values in a square block.
const SQUARE: usize = WIDTH * WIDTH;

/// Writes the map from a layer's outputs to its inputs, which starts from zero, given the layer's
/// own map. Only the panels of inputs from `first` on are written.
pub(super) fn transpose(layer: &Layer, map: &[PanelRow], first: usize, out: &mut Panels) {
    let out = out.reshape(layer.output + 1, layer.input - first * WIDTH);
    Arch::new().dispatch(Transpose { layer, map, first, out });
}

struct Transpose<'a> {
    layer: &'a Layer,
    map: &'a [PanelRow],
    first: usize,
    out: &'a mut [PanelRow],
}

impl WithSimd for Transpose<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { layer, map, first, out } = self;
        for (panel, out) in (first..).zip(out.chunks_exact_mut(layer.output + 1)) {
            let inputs = panel * WIDTH..layer.input.min((panel + 1) * WIDTH);
            let (out, start) = out.split_at_mut(layer.output);
            for (map, out) in map.chunks_exact(layer.input + 1).zip(out.chunks_mut(WIDTH)) {
                transpose_rows(&map[inputs.clone()], out);
            }
            start.fill(PanelRow::default());
        }
    }
}

/// Writes the columns of at most 16 lines as lines; at most 16 of these are wanted.
#[inline(always)]
fn transpose_rows(lines: &[PanelRow], out: &mut [PanelRow]) {
    let from: &[f32] = bytemuck::cast_slice(lines);
    let to: &mut [f32] = bytemuck::cast_slice_mut(out);
    if let (Ok(from), Ok(to)) = (from.try_into(), (&mut *to).try_into()) {
        return transpose_square(from, to);
    }
    let mut square = [0.0; SQUARE];
    let mut turned = [0.0; SQUARE];
    square[..from.len()].copy_from_slice(from);
    transpose_square(&square, &mut turned);
    to.copy_from_slice(&turned[..to.len()]);
}

/// Transposes by four interleavings. Each makes a position's highest bit its lowest, so row and
/// column change places. The compiler vectorises these, but not the plain loops.
#[inline(always)]
fn transpose_square(from: &[f32; SQUARE], to: &mut [f32; SQUARE]) {
    let mut a = [0.0; SQUARE];
    let mut b = [0.0; SQUARE];
    interleave(from, &mut a);
    interleave(&a, &mut b);
    interleave(&b, &mut a);
    interleave(&a, to);
}

/// Takes values alternately from the first and the second half.
#[inline(always)]
fn interleave(from: &[f32; SQUARE], to: &mut [f32; SQUARE]) {
    let (upper, lower) = from.split_at(SQUARE / 2);
    for ((to, &a), &b) in to.as_chunks_mut().0.iter_mut().zip(upper).zip(lower) {
        *to = [a, b];
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::Layout;
    use super::*;
    use crate::shape::Shape;

    #[test]
    fn rows_become_columns_from_any_panel() {
        let shape = Shape::new(37, &[21], 1);
        let flat: Vec<f32> = (0..shape.len()).map(|i| i as f32 + 1.0).collect();
        let layer = &shape.layers()[0];
        let map = Layout::new(shape.clone()).pack(&flat);
        for first in 0..3 {
            let inputs = layer.input - first * WIDTH;
            let mut out = Panels::default();
            out.reshape(50, 50).fill(PanelRow([9.0; WIDTH]));
            transpose(layer, &map, first, &mut out);
            let mut wanted = Panels::default();
            let columns = (0..layer.output)
                .flat_map(|o| flat[o * layer.input + first * WIDTH..][..inputs].to_vec());
            let dense: Vec<f32> = columns.chain(vec![0.0; inputs]).collect();
            wanted.set(layer.output + 1, &[&dense]);
            assert_eq!(out.lines(), wanted.lines(), "from panel {first} on");
        }
    }
}
