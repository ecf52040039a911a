//! Buffers of plain numbers, and the elementwise passes beside the matrix products.

use bytemuck::{cast_slice, cast_slice_mut};
use pulp::Arch;

use super::panels::PanelRow;

/// The first `len` values of a buffer that grows if necessary.
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

/// to <- to + scale by
pub(super) fn add(to: &mut [PanelRow], by: &[PanelRow], scale: f32) {
    let to: &mut [f32] = cast_slice_mut(to);
    let by: &[f32] = cast_slice(by);
    Arch::new().dispatch(|| to.iter_mut().zip(by).for_each(|(to, by)| *to += scale * by));
}

/// values <- scale values
pub(super) fn scale(values: &mut [PanelRow], scale: f32) {
    let values: &mut [f32] = cast_slice_mut(values);
    Arch::new().dispatch(|| values.iter_mut().for_each(|x| *x *= scale));
}

/// Sets values to zero wherever an activation is not positive.
pub(super) fn mask(values: &mut [PanelRow], activation: &[PanelRow]) {
    let values: &mut [f32] = cast_slice_mut(values);
    let activation: &[f32] = cast_slice(activation);
    for (value, &activation) in values.iter_mut().zip(activation) {
        *value = if activation > 0.0 { *value } else { 0.0 };
    }
}

/// The sum of all squares, in one order for vectors of any width.
pub(super) fn squares(lines: &[PanelRow]) -> f64 {
    let mut sums = PanelRow::default();
    Arch::new().dispatch(|| {
        for line in lines {
            sums.0.iter_mut().zip(&line.0).for_each(|(sum, x)| *sum += x * x);
        }
    });
    sums.0.iter().map(|&sum| f64::from(sum)).sum()
}

/// tanh of every value, by `libm`, so that no platform's own tanh changes a run.
pub(super) fn tanh(values: &mut [f32]) {
    values.iter_mut().for_each(|x| *x = libm::tanhf(*x));
}

/// Backward through tanh, from its output: 1 - tanh^2.
pub(super) fn tanh_backward(grad: &mut [f32], output: &[f32]) {
    grad.iter_mut().zip(output).for_each(|(grad, y)| *grad *= 1.0 - y * y);
}
