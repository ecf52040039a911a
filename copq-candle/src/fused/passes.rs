//! The elementwise passes between matrix products, each once over its data, at the widest SIMD the machine has.

use pulp::Arch;

/// Adds a bias to every row.
pub(super) fn add_bias(rows: &mut [f32], bias: &[f32]) {
    Arch::new().dispatch(|| {
        for row in rows.chunks_exact_mut(bias.len()) {
            row.iter_mut().zip(bias).for_each(|(x, b)| *x += b);
        }
    });
}

/// Adds a bias to every row and takes max(0, x); a NaN stays one, as in PyTorch.
pub(super) fn add_bias_relu(rows: &mut [f32], bias: &[f32]) {
    Arch::new().dispatch(|| {
        for row in rows.chunks_exact_mut(bias.len()) {
            for (x, b) in row.iter_mut().zip(bias) {
                let sum = *x + b;
                *x = if sum < 0.0 { 0.0 } else { sum };
            }
        }
    });
}

/// Backward through ReLU: the gradient is 0 wherever the saved activation is not positive (so also at 0, as in PyTorch).
pub(super) fn mask_relu(grad: &mut [f32], activation: &[f32]) {
    Arch::new().dispatch(|| {
        for (grad, activation) in grad.iter_mut().zip(activation) {
            // A factor, for of a choice or a bit mask the compiler makes a conditional store, slow on AMD's processors.
            *grad *= if *activation > 0.0 { 1.0 } else { 0.0 };
        }
    });
}

/// The bias's gradient: sums of the columns.
pub(super) fn sum_rows(rows: &[f32], out: &mut [f32]) {
    out.fill(0.0);
    Arch::new().dispatch(|| {
        for row in rows.chunks_exact(out.len()) {
            out.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        }
    });
}

/// Polyak averaging: target <- (1 - tau) target + tau online.
pub(super) fn polyak(target: &mut [f32], online: &[f32], tau: f32) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relu_is_pytorchs_at_zero_and_at_nan() {
        let mut rows = [-1.0, 0.0, f32::NAN, 2.0];
        add_bias_relu(&mut rows, &[0.0, 0.0, 0.0, -0.5]);
        assert!(rows[..2] == [0.0, 0.0] && rows[2].is_nan() && rows[3] == 1.5);
        let mut grad = [1.0; 4];
        mask_relu(&mut grad, &rows);
        assert_eq!(grad, [0.0, 0.0, 0.0, 1.0]);
    }
}
