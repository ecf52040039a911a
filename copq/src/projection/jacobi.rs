//! Singular values by one-sided Jacobi rotations: X = Z S V', accurate for objectives of any
//! scales.

use super::Deviations;
use super::vector::{dot, rms};

/// Sweeps after which the rotations stop in any case; generic matrices need six to ten.
pub(super) const SWEEPS: usize = 30;

/// Writes the singular values s_i of X / sqrt(K), the columns z_i of Z (`objectives x critics`, z_i
/// . z_i = K), and the columns v_i of V (`objectives x objectives`).
///
/// A singular value that is only rounding error is set to exactly zero, and so is its z_i.
/// (One-sided Jacobi: Demmel and Veselic 1992.)
pub(super) fn decompose(x: &Deviations<'_>, s: &mut [f64], z: &mut [f64], v: &mut [f64]) {
    z.copy_from_slice(x.values());
    identity(x.objectives(), v);
    for _ in 0..SWEEPS {
        drop_rounding(x, z, v);
        if !sweep(x.critics(), x.objectives(), z, v) {
            break;
        }
    }
    for (s, z) in s.iter_mut().zip(z.chunks_exact_mut(x.critics())) {
        *s = rms(z);
        if *s > 0.0 {
            z.iter_mut().for_each(|z| *z /= *s);
        }
    }
}

fn identity(n: usize, v: &mut [f64]) {
    v.fill(0.0);
    v.iter_mut().step_by(n + 1).for_each(|v| *v = 1.0);
}

/// Sets to zero every column X v_i that is only the rounding error of its terms.
fn drop_rounding(x: &Deviations<'_>, z: &mut [f64], v: &[f64]) {
    for (z, v) in z.chunks_exact_mut(x.critics()).zip(v.chunks_exact(x.objectives())) {
        if x.is_rounding(v, rms(z)) {
            z.fill(0.0);
        }
    }
}

/// Makes every pair of columns orthogonal once; returns whether any pair was not.
fn sweep(k: usize, n: usize, z: &mut [f64], v: &mut [f64]) -> bool {
    let mut rotated = false;
    for j in 1..n {
        for i in 0..j {
            let (z_i, z_j) = pair(z, k, i, j);
            if let Some(rotation) = rotation(z_i, z_j) {
                rotate(z_i, z_j, rotation);
                let (v_i, v_j) = pair(v, n, i, j);
                rotate(v_i, v_j, rotation);
                rotated = true;
            }
        }
    }
    rotated
}

/// Columns i < j of a matrix whose columns have `length` entries.
#[inline(always)]
pub(super) fn pair(
    matrix: &mut [f64],
    length: usize,
    i: usize,
    j: usize,
) -> (&mut [f64], &mut [f64]) {
    let (before, after) = matrix.split_at_mut(j * length);
    (&mut before[i * length..(i + 1) * length], &mut after[..length])
}

/// The cosine and sine that make two columns orthogonal, or nothing if they already are.
fn rotation(a: &[f64], b: &[f64]) -> Option<(f64, f64)> {
    let zeta = cotangent(dot(a, a), dot(b, b), dot(a, b), a.len())?;
    let tangent = zeta.signum() / (zeta.abs() + libm::hypot(zeta, 1.0));
    let cosine = 1.0 / libm::hypot(tangent, 1.0);
    Some((cosine, cosine * tangent))
}

/// The cotangent of twice the angle that makes two columns orthogonal, given their products;
/// nothing if they already are.
#[inline(always)]
pub(super) fn cotangent(aa: f64, bb: f64, ab: f64, length: usize) -> Option<f64> {
    let orthogonal = ab.abs() <= f64::EPSILON * length as f64 * (aa * bb).sqrt();
    if orthogonal || !ab.is_finite() {
        return None;
    }
    Some((bb - aa) / (2.0 * ab))
}

/// Rotates two columns by an angle with this cosine and sine.
#[inline(always)]
pub(super) fn rotate(a: &mut [f64], b: &mut [f64], (cosine, sine): (f64, f64)) {
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
    }
}
