//! Singular values of many objectives: a QR with pivots, then a few cheap Jacobi rotations.

use std::mem::MaybeUninit;

use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_left_in_place_scratch as apply_scratch,
    apply_block_householder_sequence_on_the_left_in_place_with_conj as apply,
};
use faer::linalg::qr::col_pivoting::factor::{qr_in_place, qr_in_place_scratch};
use faer::{Conj, MatMut, MatRef, Par};
use pulp::Arch;

use super::Deviations;
use super::jacobi::{SWEEPS, cotangent, pair, rotate};

/// Partial sums of a product, so that vectors of any width add in the same order.
const LANES: usize = 8;

/// Memory of the factors, reused from row to row.
#[derive(Clone, Debug, Default)]
pub(super) struct Factors {
    /// X, then R and the reflections that make Q (`critics x objectives`), and their coefficients.
    qr: Vec<f64>,
    coefficients: Vec<f64>,
    /// The position in X of each column of R, and the inverse.
    order: Vec<usize>,
    inverse: Vec<usize>,
    /// W = R', whose columns the rotations make orthogonal, their squares, and the rotations J.
    w: Vec<f64>,
    squares: Vec<f64>,
    j: Vec<f64>,
    stack: Vec<MaybeUninit<u8>>,
}

impl Factors {
    /// Writes what [`decompose`](super::jacobi::decompose) writes. Returns false, with
    /// anything written, unless X has as many singular values that are not rounding errors as
    /// objectives.
    ///
    /// X P = Q R, and R' J = V S by one-sided Jacobi, so that X = (Q J) S (P V)'. Pivots sort the
    /// rows of R by size, which leaves few rotations and keeps small singular values to all their
    /// digits (Drmac and Veselic 2008).
    pub(super) fn decompose(
        &mut self,
        x: &Deviations<'_>,
        s: &mut [f64],
        z: &mut [f64],
        v: &mut [f64],
    ) -> bool {
        let k = x.critics();
        let n = x.objectives();
        if k <= n {
            return false;
        }
        self.factor(x);
        self.transpose(k, n);
        let Self { w, squares, j, .. } = self;
        Arch::new().dispatch(|| orthogonalise(n, w, squares, j));
        self.write(k, n, s, z, v);
        let is_value = |(s, v): (&f64, &[f64])| *s > 0.0 && s.is_finite() && !x.is_rounding(v, *s);
        s.iter().zip(v.chunks_exact(n)).all(is_value)
    }

    /// X P = Q R
    fn factor(&mut self, x: &Deviations<'_>) {
        let k = x.critics();
        let n = x.objectives();
        self.qr.clear();
        self.qr.extend_from_slice(x.values());
        self.coefficients.resize(block(n) * n, 0.0);
        self.order.resize(n, 0);
        self.inverse.resize(n, 0);
        let factoring =
            qr_in_place_scratch::<usize, f64>(k, n, block(n), Par::Seq, Default::default());
        let applying = apply_scratch::<f64>(k, block(n), n);
        let bytes = StackReq::any_of(&[factoring, applying]).unaligned_bytes_required();
        self.stack.resize(bytes, MaybeUninit::uninit());
        qr_in_place(
            MatMut::from_column_major_slice_mut(&mut self.qr, k, n),
            MatMut::from_column_major_slice_mut(&mut self.coefficients, block(n), n),
            &mut self.order,
            &mut self.inverse,
            Par::Seq,
            MemStack::new(&mut self.stack),
            Default::default(),
        );
    }

    /// W = R', J = 1
    fn transpose(&mut self, k: usize, n: usize) {
        let Self { qr, w, j, .. } = self;
        w.resize(n * n, 0.0);
        for (row, w) in w.chunks_exact_mut(n).enumerate() {
            for (column, w) in w.iter_mut().enumerate() {
                *w = if column < row { 0.0 } else { qr[column * k + row] };
            }
        }
        j.clear();
        j.resize(n * n, 0.0);
        j.iter_mut().step_by(n + 1).for_each(|j| *j = 1.0);
    }

    /// W J = V S gives s and v, Q J gives z.
    fn write(&mut self, k: usize, n: usize, s: &mut [f64], z: &mut [f64], v: &mut [f64]) {
        let root = (k as f64).sqrt();
        z.fill(0.0);
        for (i, (w, j)) in self.w.chunks_exact(n).zip(self.j.chunks_exact(n)).enumerate() {
            let length = dot(w, w).sqrt();
            s[i] = length / root;
            for (&column, w) in self.order.iter().zip(w) {
                v[i * n + column] = w / length;
            }
            for (z, j) in z[i * k..].iter_mut().zip(j) {
                *z = root * j;
            }
        }
        apply(
            MatRef::from_column_major_slice(&self.qr, k, n),
            MatRef::from_column_major_slice(&self.coefficients, block(n), n),
            Conj::No,
            MatMut::from_column_major_slice_mut(z, k, n),
            Par::Seq,
            MemStack::new(&mut self.stack),
        );
    }
}

/// How many reflections are applied at once.
fn block(n: usize) -> usize {
    if n < 16 { 1 } else { 8 }
}

/// Rotates W's n columns until they are orthogonal, and J's with them.
#[inline(always)]
fn orthogonalise(n: usize, w: &mut [f64], squares: &mut Vec<f64>, j: &mut [f64]) {
    for _ in 0..SWEEPS {
        squares.clear();
        squares.extend(w.chunks_exact(n).map(|w| dot(w, w)));
        let mut rotated = false;
        for b in 1..n {
            for a in 0..b {
                let (w_a, w_b) = pair(w, n, a, b);
                let product = dot(w_a, w_b);
                let Some(zeta) = cotangent(squares[a], squares[b], product, n) else { continue };
                // Not hypot, which is used for few objectives: it would cost a fifth more.
                let tangent = 1_f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                let rotation = (cosine, cosine * tangent);
                rotate(w_a, w_b, rotation);
                squares[a] -= tangent * product;
                squares[b] += tangent * product;
                let (j_a, j_b) = pair(j, n, a, b);
                rotate(j_a, j_b, rotation);
                rotated = true;
            }
        }
        if !rotated {
            break;
        }
    }
}

/// a . b in eight sums, for vectors of any width.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<LANES>();
    let (b, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    for (sum, (a, b)) in sums.iter_mut().zip(a_rest.iter().zip(b_rest)) {
        *sum += a * b;
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    use super::super::jacobi;
    use super::*;
    use crate::{Rng, Stream};

    /// Centred columns, of sizes from 1 to 1e-9 in no order.
    fn deviations(k: usize, n: usize) -> Vec<f64> {
        let mut normals = vec![0.0; k * n];
        Rng::new(k as u64, Stream::Batch).fill_normal(&mut normals);
        let mut x: Vec<f64> = normals.into_iter().map(f64::from).collect();
        for (i, column) in x.chunks_exact_mut(k).enumerate() {
            let mean = column.iter().sum::<f64>() / k as f64;
            let size = 10_f64.powi(-((7 * i as i32) % 10));
            column.iter_mut().for_each(|x| *x = (*x - mean) * size);
        }
        x
    }

    #[test]
    fn singular_values_have_all_their_digits() {
        for (k, n) in [(11, 10), (26, 25), (51, 50), (64, 20)] {
            let values = deviations(k, n);
            let x = Deviations::new(&values, k).unwrap();
            let mut factors = Factors::default();
            let [mut s, mut wanted] = [vec![0.0; n], vec![0.0; n]];
            let [mut z, mut v] = [vec![0.0; k * n], vec![0.0; n * n]];
            jacobi::decompose(&x, &mut wanted, &mut z, &mut v);
            assert!(factors.decompose(&x, &mut s, &mut z, &mut v), "{k} critics");
            for (i, column) in values.chunks_exact(k).enumerate() {
                for (row, &x) in column.iter().enumerate() {
                    let term = |j| s[j] * z[j * k + row] * v[j * n + i];
                    let product: f64 = (0..n).map(term).sum();
                    let size = column.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
                    assert_abs_diff_eq!(product, x, epsilon = 1e-13 * size);
                }
            }
            s.sort_by(f64::total_cmp);
            wanted.sort_by(f64::total_cmp);
            for (s, wanted) in s.iter().zip(wanted) {
                assert_relative_eq!(*s, wanted, max_relative = 1e-13);
            }
        }
    }

    #[test]
    fn what_spans_fewer_dimensions_is_left_to_plain_rotations() {
        let mut values = deviations(11, 10);
        let (first, second) = values.split_at_mut(11);
        second[..11].copy_from_slice(first);
        let [mut s, mut z, mut v] = [vec![0.0; 10], vec![0.0; 110], vec![0.0; 100]];
        let x = Deviations::new(&values, 11).unwrap();
        assert!(!Factors::default().decompose(&x, &mut s, &mut z, &mut v));
        let x = Deviations::new(&values[..50], 5).unwrap();
        assert!(!Factors::default().decompose(&x, &mut s, &mut z[..50], &mut v));
    }
}
