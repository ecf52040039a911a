//! Gram-Schmidt in priority order, and its reverse: orthonormal directions e_j in the space of
//! critics.

use super::deviations::ROUNDING;
use super::vector::{add_scaled, centre, divide, dot, over, rms, subtract_scaled};

/// Writes e_1..e_N, `objectives x critics` like the deviations x, and the N pivots L_jj = sqrt(r_j
/// . r_j / K).
///
/// e_j = r_j / L_jj, where r_j is x_j without its parts along the earlier e's, so that e_j . e_j =
/// K. An objective whose disagreement the earlier ones explain entirely has a zero pivot and a zero
/// e_j. Centred columns span at most K - 1 dimensions, so at most that many pivots are taken.
pub(super) fn orthonormalise(x: &[f64], e: &mut [f64], pivots: &mut [f64]) {
    let critics = x.len() / pivots.len();
    let mut room = critics - 1;
    for (j, column) in x.chunks_exact(critics).enumerate() {
        let (before, after) = e.split_at_mut(j * critics);
        let e = &mut after[..critics];
        let pivot = orthogonalise(column, before, e);
        if room == 0 || pivot == 0.0 {
            e.fill(0.0);
            continue;
        }
        divide(e, pivot);
        pivots[j] = pivot;
        room -= 1;
    }
}

/// Writes r_j and returns its pivot, which is zero if it is only rounding error.
fn orthogonalise(column: &[f64], before: &[f64], r: &mut [f64]) -> f64 {
    r.copy_from_slice(column);
    remove(before, r);
    // The second pass corrects the rounding errors that remain after the first, which a small pivot
    // would amplify ("twice is enough").
    remove(before, r);
    let length = rms(r);
    if ROUNDING * rms(column) < length { length } else { 0.0 }
}

/// Makes r orthogonal to the earlier e's, and to (1, ..., 1).
fn remove(before: &[f64], r: &mut [f64]) {
    for e in before.chunks_exact(r.len()) {
        let along = over(dot(r, e), r.len());
        subtract_scaled(r, along, e);
    }
    centre(r);
}

/// Adds to `grad_x` what follows from `grad_e`, the gradient with respect to e_1..e_N, which it
/// overwrites.
///
/// A zero pivot passes no gradient on.
pub(super) fn orthonormalise_vjp(
    x: &[f64],
    e: &[f64],
    pivots: &[f64],
    grad_e: &mut [f64],
    grad_x: &mut [f64],
) {
    let critics = x.len() / pivots.len();
    for (j, &pivot) in pivots.iter().enumerate().rev() {
        if pivot == 0.0 {
            continue;
        }
        let (before, after) = grad_e.split_at_mut(j * critics);
        let column = j * critics..(j + 1) * critics;
        let earlier = &e[..j * critics];
        let grad = &mut after[..critics];
        rotate_back(earlier, &e[column.clone()], grad, before);
        divide_back(earlier, &e[column.clone()], &x[column.clone()], pivot, grad, before);
        add_scaled(&mut grad_x[column], 1.0, grad);
    }
}

/// Moves the parts of grad_j along an earlier e_k to grad_k.
///
/// The e's stay orthogonal, so e_k . de_j = -e_j . de_k. Going through r_j instead would divide
/// these parts by a small pivot, only for them to cancel later.
fn rotate_back(earlier: &[f64], e: &[f64], grad: &mut [f64], before: &mut [f64]) {
    for (earlier, before) in earlier.chunks_exact(e.len()).zip(before.chunks_exact_mut(e.len())) {
        let along = over(dot(grad, earlier), e.len());
        subtract_scaled(grad, along, earlier);
        subtract_scaled(before, along, e);
    }
}

/// From the gradient of e_j = r_j / L_jj to that of r_j = x_j - sum_k L_jk e_k, and on to the e_k.
fn divide_back(
    earlier: &[f64],
    e: &[f64],
    column: &[f64],
    pivot: f64,
    grad: &mut [f64],
    before: &mut [f64],
) {
    let along = over(dot(grad, e), e.len());
    subtract_scaled(grad, along, e);
    divide(grad, pivot);
    for (earlier, before) in earlier.chunks_exact(e.len()).zip(before.chunks_exact_mut(e.len())) {
        subtract_scaled(before, over(dot(column, earlier), e.len()), grad);
    }
}
