//! One row of a batch in double precision, or several: mean, deviations, direction, and the way
//! back to f32.

use super::number::Number;
use super::vector::{centre, mean, normalise, over};
use super::{Directions, QView};

/// The row that is being projected (`T::ROWS` rows, from `row` on), and the vectors that go in and
/// out of an ellipsoid.
#[derive(Clone, Debug)]
pub(super) struct Row<T> {
    critics: usize,
    /// The critics' value nearest zero, one per objective.
    reference: Vec<T>,
    /// The mean's distance from the reference.
    shift: Vec<T>,
    /// X, `objectives x critics`.
    pub(super) deviations: Vec<T>,
    /// u
    pub(super) unit: Vec<T>,
    pub(super) offset: Vec<T>,
    pub(super) grad: Vec<T>,
    pub(super) grad_x: Vec<T>,
}

impl<T> Default for Row<T> {
    fn default() -> Self {
        let [reference, shift, deviations, unit, offset, grad, grad_x] = [const { Vec::new() }; 7];
        Self { critics: 0, reference, shift, deviations, unit, offset, grad, grad_x }
    }
}

impl<T: Number> Row<T> {
    /// Makes room for rows of this shape.
    pub(super) fn resize(&mut self, q: QView<'_>) {
        self.critics = q.critics();
        for vector in
            [&mut self.reference, &mut self.shift, &mut self.unit, &mut self.offset, &mut self.grad]
        {
            vector.resize(q.objectives(), T::all(0.0));
        }
        for matrix in [&mut self.deviations, &mut self.grad_x] {
            matrix.resize(q.critics() * q.objectives(), T::all(0.0));
        }
    }

    /// Reads the weights and makes them the unit direction u = w / |w| (paper eq. 2).
    #[inline(always)]
    pub(super) fn load_unit(&mut self, row: usize, directions: &Directions<'_>) {
        for (i, unit) in self.unit.iter_mut().enumerate() {
            *unit = T::from_rows(|lane| directions.weights(row + lane)[i].into());
        }
        normalise(&mut self.unit);
    }

    /// Reads the critics' values.
    #[inline(always)]
    pub(super) fn load(&mut self, q: QView<'_>, row: usize) {
        let n = q.objectives();
        for k in 0..self.critics {
            let values = &q.values()[q.range(k, row).start..][..T::ROWS * n];
            for i in 0..n {
                self.deviations[i * self.critics + k] =
                    T::from_rows(|lane| values[lane * n + i].into());
            }
        }
        for (i, column) in self.deviations.chunks_exact_mut(self.critics).enumerate() {
            // Deviations from the value nearest zero lose nothing: a difference of two f32 is right
            // to half an ulp of the difference, however far from zero both are, and adding it back
            // gives the f32 again, to the bit.
            let reference = column.iter().copied().fold(T::all(f64::INFINITY), nearer_zero);
            for x in column.iter_mut() {
                *x = *x - reference;
            }
            self.reference[i] = reference;
            self.shift[i] = centre(column);
        }
    }

    /// The bound: mean + step * offset.
    #[inline(always)]
    pub(super) fn write_bound(&self, row: usize, step: f64, out: &mut [f32]) {
        let n = self.offset.len();
        let out = &mut out[row * n..][..T::ROWS * n];
        for i in 0..n {
            let bound = self.reference[i] + (self.shift[i] + T::all(step) * self.offset[i]);
            (0..T::ROWS).for_each(|lane| out[lane * n + i] = bound.row(lane) as f32);
        }
    }

    /// Reads the gradient of the bound.
    #[inline(always)]
    pub(super) fn load_grad(&mut self, row: usize, grad_out: &[f32]) {
        let n = self.grad.len();
        let grad_out = &grad_out[row * n..][..T::ROWS * n];
        for (i, grad) in self.grad.iter_mut().enumerate() {
            *grad = T::from_rows(|lane| grad_out[lane * n + i].into());
        }
        self.grad_x.fill(T::all(0.0));
    }

    /// dL/dQ: the mean hands every critic an equal share, and an offset that depends on Q - mean
    /// only hands out what sums to zero.
    #[inline(always)]
    pub(super) fn write_grad(&self, q: QView<'_>, row: usize, step: f64, grad_q: &mut [f32]) {
        let n = q.objectives();
        for (i, grad_x) in self.grad_x.chunks_exact(self.critics).enumerate() {
            let share = over(self.grad[i], self.critics);
            let excess = mean(grad_x);
            for (k, &grad_x) in grad_x.iter().enumerate() {
                let grad = share + T::all(step) * (grad_x - excess);
                let grad_q = &mut grad_q[q.range(k, row).start..][..T::ROWS * n];
                (0..T::ROWS).for_each(|lane| grad_q[lane * n + i] = grad.row(lane) as f32);
            }
        }
    }
}

#[inline(always)]
fn nearer_zero<T: Number>(a: T, b: T) -> T {
    T::if_less(b.abs(), a.abs(), b, a)
}
