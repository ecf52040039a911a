//! Buffers of plain numbers, and the elementwise passes beside the matrix products.

use bytemuck::{cast_slice, cast_slice_mut};
use pulp::Arch;

use super::panels::PanelRow;

/// The first `len` values of a buffer that grows when it must.
pub(super) fn room(buffer: &mut Vec<f32>, len: usize) -> &mut [f32] {
    if buffer.len() < len {
        buffer.resize(len, 0.0);
    }
    &mut buffer[..len]
}

/// Polyak averaging: target <- (1 - tau) target + tau online.
pub(super) fn polyak(target: &mut [PanelRow], online: &[PanelRow], tau: f32) {
    let target: &mut [f32] = cast_slice_mut(target);
    let online: &[f32] = cast_slice(online);
    Arch::new().dispatch(|| {
        for (target, online) in target.iter_mut().zip(online) {
            *target = (1.0 - tau) * *target + tau * online;
        }
    });
}

/// tanh of every value, by `libm` so that no platform's own changes a run.
pub(super) fn tanh(values: &mut [f32]) {
    values.iter_mut().for_each(|x| *x = libm::tanhf(*x));
}

/// Backward through tanh, from its output: 1 - tanh^2.
pub(super) fn tanh_backward(grad: &mut [f32], output: &[f32]) {
    grad.iter_mut().zip(output).for_each(|(grad, y)| *grad *= 1.0 - y * y);
}
