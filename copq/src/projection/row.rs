//! One row of a batch in double precision: its mean, its deviations, its direction, and the way back to f32.

use super::vector::{centre, mean};
use super::{Deviations, Directions, QView};

/// The row that is being projected, and the vectors that go in and out of an ellipsoid.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    critics: usize,
    /// The critics' value nearest zero, one an objective.
    reference: Vec<f64>,
    /// The mean's distance from the reference.
    shift: Vec<f64>,
    deviations: Vec<f64>,
    pub(super) unit: Vec<f64>,
    pub(super) offset: Vec<f64>,
    pub(super) grad: Vec<f64>,
    pub(super) grad_x: Vec<f64>,
}

impl Row {
    /// Reads one row.
    pub(super) fn load(&mut self, q: QView<'_>, row: usize, directions: &Directions<'_>) {
        self.resize(q.critics(), q.objectives());
        directions.unit(row, &mut self.unit);
        for (i, column) in self.deviations.chunks_exact_mut(q.critics()).enumerate() {
            // Deviations from the value nearest zero lose nothing: a difference of two f32 is right to half an ulp of
            // the difference, however far from zero both are, and adding it back gives the f32 again, to the bit.
            let values = (0..q.critics()).map(|k| f64::from(q.get(k, row)[i]));
            let reference = values.clone().fold(f64::INFINITY, nearer_zero);
            column.iter_mut().zip(values).for_each(|(x, value)| *x = value - reference);
            self.reference[i] = reference;
            self.shift[i] = centre(column);
        }
    }

    /// X and u, then the offset to write.
    pub(super) fn offset_parts(&mut self) -> (Deviations<'_>, &[f64], &mut [f64]) {
        (Deviations::of(&self.deviations, self.critics), &self.unit, &mut self.offset)
    }

    /// X, u and the gradient of the offset, then the gradient of X to write.
    pub(super) fn vjp_parts(&mut self) -> (Deviations<'_>, &[f64], &[f64], &mut [f64]) {
        (Deviations::of(&self.deviations, self.critics), &self.unit, &self.grad, &mut self.grad_x)
    }

    /// The bound: mean + step * offset.
    pub(super) fn write_bound(&self, step: f64, out: &mut [f32]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = (self.reference[i] + (self.shift[i] + step * self.offset[i])) as f32;
        }
    }

    /// Reads the gradient of the bound.
    pub(super) fn load_grad(&mut self, grad_out: &[f32]) {
        self.grad.iter_mut().zip(grad_out).for_each(|(grad, &out)| *grad = f64::from(out));
        self.grad_x.fill(0.0);
    }

    /// dL/dQ: the mean hands every critic an equal share, and an offset that depends on Q - mean only hands out what
    /// sums to zero.
    pub(super) fn write_grad(&self, q: QView<'_>, row: usize, step: f64, grad_q: &mut [f32]) {
        for (i, grad_x) in self.grad_x.chunks_exact(self.critics).enumerate() {
            let (share, excess) = (self.grad[i] / self.critics as f64, mean(grad_x));
            for (k, grad_x) in grad_x.iter().enumerate() {
                grad_q[q.range(k, row)][i] = (share + step * (grad_x - excess)) as f32;
            }
        }
    }

    fn resize(&mut self, critics: usize, objectives: usize) {
        self.critics = critics;
        for vector in [&mut self.reference, &mut self.shift, &mut self.unit, &mut self.offset, &mut self.grad] {
            vector.resize(objectives, 0.0);
        }
        for matrix in [&mut self.deviations, &mut self.grad_x] {
            matrix.resize(critics * objectives, 0.0);
        }
    }
}

fn nearer_zero(a: f64, b: f64) -> f64 {
    if b.abs() < a.abs() { b } else { a }
}
