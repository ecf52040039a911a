//! One row of a batch in double precision: mean, deviations, direction, and the way back to f32.

use super::vector::{centre, mean, over};
use super::{Directions, QView};

/// The row that is being projected, and the vectors that go in and out of an ellipsoid.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    critics: usize,
    /// The critics' value nearest zero, one per objective.
    reference: Vec<f64>,
    /// The mean's distance from the reference.
    shift: Vec<f64>,
    /// X, `objectives x critics`.
    pub(super) deviations: Vec<f64>,
    /// u
    pub(super) unit: Vec<f64>,
    pub(super) offset: Vec<f64>,
    pub(super) grad: Vec<f64>,
    pub(super) grad_x: Vec<f64>,
}

impl Row {
    /// Makes room for rows of this shape.
    pub(super) fn resize(&mut self, q: QView<'_>) {
        self.critics = q.critics();
        for vector in
            [&mut self.reference, &mut self.shift, &mut self.unit, &mut self.offset, &mut self.grad]
        {
            vector.resize(q.objectives(), 0.0);
        }
        for matrix in [&mut self.deviations, &mut self.grad_x] {
            matrix.resize(q.critics() * q.objectives(), 0.0);
        }
    }

    /// Reads the critics' values and the direction. If all rows share one set of weights, its
    /// direction is read with the first row.
    pub(super) fn load(&mut self, q: QView<'_>, directions: &Directions<'_>, row: usize) {
        if row == 0 || !directions.shared() {
            directions.unit(row, &mut self.unit);
        }
        for k in 0..self.critics {
            for (i, &value) in q.get(k, row).iter().enumerate() {
                self.deviations[i * self.critics + k] = value.into();
            }
        }
        for (i, column) in self.deviations.chunks_exact_mut(self.critics).enumerate() {
            // Deviations from the value nearest zero lose nothing: a difference of two f32 is right
            // to half an ulp of the difference, however far both are from zero, and adding it back
            // gives the same f32, to the bit.
            let reference = column.iter().copied().fold(f64::INFINITY, nearer_zero);
            for x in column.iter_mut() {
                *x -= reference;
            }
            self.reference[i] = reference;
            self.shift[i] = centre(column);
        }
    }

    /// The bound: mean + step * offset.
    pub(super) fn write_bound(&self, row: usize, step: f64, out: &mut [f32]) {
        let n = self.offset.len();
        for (i, out) in out[row * n..(row + 1) * n].iter_mut().enumerate() {
            *out = (self.reference[i] + (self.shift[i] + step * self.offset[i])) as f32;
        }
    }

    /// Reads the gradient of the bound.
    pub(super) fn load_grad(&mut self, row: usize, grad_out: &[f32]) {
        let n = self.grad.len();
        for (grad, &grad_out) in self.grad.iter_mut().zip(&grad_out[row * n..(row + 1) * n]) {
            *grad = grad_out.into();
        }
        self.grad_x.fill(0.0);
    }

    /// dL/dQ: the mean gives every critic an equal share, and an offset that depends only on
    /// Q - mean gives shares that sum to zero.
    pub(super) fn write_grad(&self, q: QView<'_>, row: usize, step: f64, grad_q: &mut [f32]) {
        for (i, grad_x) in self.grad_x.chunks_exact(self.critics).enumerate() {
            let share = over(self.grad[i], self.critics);
            let excess = mean(grad_x);
            for (k, &grad_x) in grad_x.iter().enumerate() {
                grad_q[q.range(k, row)][i] = (share + step * (grad_x - excess)) as f32;
            }
        }
    }
}

fn nearer_zero(a: f64, b: f64) -> f64 {
    if b.abs() < a.abs() { b } else { a }
}
