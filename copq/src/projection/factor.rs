//! The Cholesky factor L of Sigma, never formed: L_ij = x_i . e_j / K for j <= i.

use super::gram_schmidt::{orthonormalise, orthonormalise_vjp};
use super::vector::{add_scaled, dot, over};

/// L, lower triangular in priority order, as deviations and orthonormal directions.
#[derive(Debug)]
pub(super) struct Factor<'a> {
    x: &'a [f64],
    critics: usize,
    e: &'a [f64],
    pivots: &'a [f64],
}

impl<'a> Factor<'a> {
    /// Factors Sigma of the deviations `x`; `e` (both `objectives x critics`) and `pivots`
    /// (`objectives`) must be zero beforehand.
    pub(super) fn new(x: &'a [f64], e: &'a mut [f64], pivots: &'a mut [f64]) -> Self {
        let critics = x.len() / pivots.len();
        orthonormalise(x, e, pivots);
        Self { x, critics, e, pivots }
    }

    /// Writes L v: the i-th entry is x_i . (e_1 v_1 + ... + e_i v_i) / K. `sum` (K) is working
    /// memory.
    pub(super) fn times(&self, v: &[f64], sum: &mut [f64], out: &mut [f64]) {
        sum.fill(0.0);
        for (i, (x, e)) in self.columns().enumerate() {
            add_scaled(sum, v[i], e);
            out[i] = over(dot(x, sum), self.critics);
        }
    }

    /// Writes L'v: the j-th entry is e_j . (x_j v_j + ... + x_N v_N) / K. `sum` (K) is working
    /// memory.
    pub(super) fn transposed_times(&self, v: &[f64], sum: &mut [f64], out: &mut [f64]) {
        sum.fill(0.0);
        for (j, (x, e)) in self.columns().enumerate().rev() {
            add_scaled(sum, v[j], x);
            out[j] = over(dot(e, sum), self.critics);
        }
    }

    /// Adds the gradients of `left . L right` with respect to X and E; both vectors are constants.
    pub(super) fn bilinear_vjp(
        &self,
        left: &[f64],
        right: &[f64],
        sum: &mut [f64],
        grad_e: &mut [f64],
        grad_x: &mut [f64],
    ) {
        let critics = self.critics;
        sum.fill(0.0);
        for (i, ((_, e), grad_x)) in
            self.columns().zip(grad_x.chunks_exact_mut(critics)).enumerate()
        {
            add_scaled(sum, right[i], e);
            add_scaled(grad_x, over(left[i], critics), sum);
        }
        sum.fill(0.0);
        for (j, ((x, _), grad_e)) in
            self.columns().zip(grad_e.chunks_exact_mut(critics)).enumerate().rev()
        {
            add_scaled(sum, left[j], x);
            add_scaled(grad_e, over(right[j], critics), sum);
        }
    }

    /// Adds to `grad_x` what follows from the gradient of E, which it overwrites.
    pub(super) fn directions_vjp(&self, grad_e: &mut [f64], grad_x: &mut [f64]) {
        orthonormalise_vjp(self.x, self.e, self.pivots, grad_e, grad_x);
    }

    /// x_j and e_j, in priority order.
    fn columns(&self) -> impl DoubleEndedIterator<Item = (&[f64], &[f64])> + ExactSizeIterator {
        self.x.chunks_exact(self.critics).zip(self.e.chunks_exact(self.critics))
    }
}
