//! A layer's weight turned round, for the way back.

use pulp::Arch;

use super::panels::{Line, WIDTH};
use crate::shape::Layer;

/// Writes the map from a layer's outputs to its inputs, whose start is zero, given the layer's own; only the panels of
/// inputs from `first` on.
pub(super) fn transpose(layer: &Layer, map: &[Line], first: usize, out: &mut Vec<Line>) {
    let panels = layer.input.div_ceil(WIDTH) - first;
    out.resize(panels * (layer.output + 1), Line::default());
    Arch::new().dispatch(|| {
        for (panel, out) in (first..).zip(out.chunks_exact_mut(layer.output + 1)) {
            let inputs = panel * WIDTH..layer.input.min((panel + 1) * WIDTH);
            let (out, start) = out.split_at_mut(layer.output);
            for (map, out) in map.chunks_exact(layer.input + 1).zip(out.chunks_mut(WIDTH)) {
                let mut block = [Line::default(); WIDTH];
                block[..inputs.len()].copy_from_slice(&map[inputs.clone()]);
                out.copy_from_slice(&turned(block)[..out.len()]);
            }
            start.fill(Line::default());
        }
    });
}

/// The transpose of 16 x 16 values: exchanges its off-diagonal quarters, then theirs, and so on.
#[inline(always)]
fn turned(mut block: [Line; WIDTH]) -> [Line; WIDTH] {
    exchange::<8>(&mut block);
    exchange::<4>(&mut block);
    exchange::<2>(&mut block);
    exchange::<1>(&mut block);
    block
}

/// Exchanges the upper right and lower left quarters of every `2 SIZE x 2 SIZE` block on the diagonal's grid.
#[inline(always)]
fn exchange<const SIZE: usize>(block: &mut [Line; WIDTH]) {
    for pair in block.chunks_exact_mut(2 * SIZE) {
        let (upper, lower) = pair.split_at_mut(SIZE);
        for (upper, lower) in upper.iter_mut().zip(lower) {
            let (a, b) = (upper.0, lower.0);
            for i in 0..WIDTH {
                let right = i & SIZE > 0;
                upper.0[i] = if right { b[i ^ SIZE] } else { a[i] };
                lower.0[i] = if right { b[i] } else { a[i ^ SIZE] };
            }
        }
    }
}
