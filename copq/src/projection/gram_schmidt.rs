//! Gram-Schmidt in priority order, and its reverse: orthonormal directions e_j in the space of critics.

use super::Deviations;
use super::deviations::ROUNDING;
use super::vector::{add_scaled, centre, dot, rms};

/// Writes e_1..e_N, `objectives x critics`, and the pivots L_jj = sqrt(r_j . r_j / K).
///
/// e_j = r_j / L_jj, where r_j is x_j without its parts along the earlier e's, so that e_j . e_j = K. An objective whose
/// disagreement the earlier ones explain entirely has a zero pivot and a zero e_j. Centred columns span at most K - 1
/// dimensions, so no more pivots than that are taken.
pub(super) fn orthonormalise(x: &Deviations<'_>, e: &mut [f64], pivots: &mut [f64]) {
    let mut rank = 0;
    for (j, column) in x.iter().enumerate() {
        let (before, after) = e.split_at_mut(j * x.critics());
        let e = &mut after[..x.critics()];
        pivots[j] = if rank + 1 < x.critics() { orthonormal(column, before, e) } else { 0.0 };
        rank += usize::from(pivots[j] > 0.0);
    }
}

/// Writes one e_j, which was zero, and returns its pivot.
fn orthonormal(column: &[f64], before: &[f64], e: &mut [f64]) -> f64 {
    e.copy_from_slice(column);
    remove(before, e);
    // The second pass mends what rounding left of the first, which a small pivot would blow up ("twice is enough").
    remove(before, e);
    let pivot = rms(e);
    if pivot > ROUNDING * rms(column) {
        e.iter_mut().for_each(|e| *e /= pivot);
        return pivot;
    }
    e.fill(0.0);
    0.0
}

/// Makes r orthogonal to the earlier e's, and to (1, ..., 1).
fn remove(before: &[f64], r: &mut [f64]) {
    for e in before.chunks_exact(r.len()) {
        let along = dot(r, e) / r.len() as f64;
        add_scaled(r, -along, e);
    }
    centre(r);
}

/// Adds to `grad_x` what follows from `grad_e`, the gradient with respect to e_1..e_N, which it uses up.
///
/// A zero pivot passes no gradient on.
pub(super) fn orthonormalise_vjp(
    x: &Deviations<'_>,
    e: &[f64],
    pivots: &[f64],
    grad_e: &mut [f64],
    grad_x: &mut [f64],
) {
    let critics = x.critics();
    for j in (0..x.objectives()).rev() {
        let (before, after) = grad_e.split_at_mut(j * critics);
        if pivots[j] > 0.0 {
            let parts = (&e[..j * critics], &e[j * critics..(j + 1) * critics]);
            let grad = &mut after[..critics];
            turn_back(parts, grad, before);
            divide_back(parts, x.objective(j), pivots[j], grad, before);
            add_scaled(&mut grad_x[j * critics..(j + 1) * critics], 1.0, grad);
        }
    }
}

/// Moves the parts of grad_j along an earlier e_k to grad_k.
///
/// The e's stay orthogonal, so e_k . de_j = -e_j . de_k. Going through r_j instead would divide these parts by a small
/// pivot, only for them to cancel later.
fn turn_back((earlier, e): (&[f64], &[f64]), grad: &mut [f64], before: &mut [f64]) {
    for (earlier, before) in earlier.chunks_exact(e.len()).zip(before.chunks_exact_mut(e.len())) {
        let along = dot(grad, earlier) / e.len() as f64;
        add_scaled(grad, -along, earlier);
        add_scaled(before, -along, e);
    }
}

/// From the gradient of e_j = r_j / L_jj to that of r_j = x_j - sum_k L_jk e_k, and on to the e_k.
fn divide_back((earlier, e): (&[f64], &[f64]), column: &[f64], pivot: f64, grad: &mut [f64], before: &mut [f64]) {
    let along = dot(grad, e) / e.len() as f64;
    add_scaled(grad, -along, e);
    grad.iter_mut().for_each(|grad| *grad /= pivot);
    for (earlier, before) in earlier.chunks_exact(e.len()).zip(before.chunks_exact_mut(e.len())) {
        add_scaled(before, -dot(column, earlier) / e.len() as f64, grad);
    }
}
