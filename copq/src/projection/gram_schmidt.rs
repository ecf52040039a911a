//! Gram-Schmidt in priority order, and its reverse: orthonormal directions e_j in the space of
//! critics.

use super::deviations::ROUNDING;
use super::number::Number;
use super::vector::{add_scaled, centre, divide, dot, over, rms};

/// Writes e_1..e_N, `objectives x critics` like the deviations x, and the N pivots L_jj = sqrt(r_j
/// . r_j / K).
///
/// e_j = r_j / L_jj, where r_j is x_j without its parts along the earlier e's, so that e_j . e_j =
/// K. An objective whose disagreement the earlier ones explain entirely has a zero pivot and a zero
/// e_j. Centred columns span at most K - 1 dimensions, so no more pivots than that are taken.
#[inline(always)]
pub(super) fn orthonormalise<T: Number>(x: &[T], e: &mut [T], pivots: &mut [T]) {
    let critics = x.len() / pivots.len();
    let zero = T::all(0.0);
    let one = T::all(1.0);
    let mut room = T::all(critics as f64 - 1.0);
    for (j, column) in x.chunks_exact(critics).enumerate() {
        let (before, after) = e.split_at_mut(j * critics);
        pivots[j] = orthonormal(column, before, &mut after[..critics], room);
        room = room - T::if_less(zero, pivots[j], one, zero);
    }
}

/// Writes one e_j and returns its pivot; both are zero where there is no `room` left.
#[inline(always)]
fn orthonormal<T: Number>(column: &[T], before: &[T], e: &mut [T], room: T) -> T {
    let zero = T::all(0.0);
    e.copy_from_slice(column);
    remove(before, e);
    // The second pass mends what rounding left of the first, which a small pivot would blow up
    // ("twice is enough").
    remove(before, e);
    let length = rms(e);
    let own = T::if_less(T::all(ROUNDING) * rms(column), length, length, zero);
    let pivot = T::if_less(zero, room, own, zero);
    for e in e.iter_mut() {
        *e = T::if_less(zero, pivot, *e / pivot, zero);
    }
    pivot
}

/// Makes r orthogonal to the earlier e's, and to (1, ..., 1).
#[inline(always)]
fn remove<T: Number>(before: &[T], r: &mut [T]) {
    for e in before.chunks_exact(r.len()) {
        let along = over(dot(r, e), r.len());
        subtract_scaled(r, along, e);
    }
    centre(r);
}

/// Adds to `grad_x` what follows from `grad_e`, the gradient with respect to e_1..e_N, which it
/// uses up.
///
/// A zero pivot passes no gradient on.
#[inline(always)]
pub(super) fn orthonormalise_vjp<T: Number>(
    (x, e, pivots): (&[T], &[T], &[T]),
    grad_e: &mut [T],
    grad_x: &mut [T],
) {
    let critics = x.len() / pivots.len();
    let zero = T::all(0.0);
    let one = T::all(1.0);
    for (j, &pivot) in pivots.iter().enumerate().rev() {
        let (before, after) = grad_e.split_at_mut(j * critics);
        let column = j * critics..(j + 1) * critics;
        let grad = &mut after[..critics];
        for grad in grad.iter_mut() {
            *grad = T::if_less(zero, pivot, *grad, zero);
        }
        let parts = (&e[..j * critics], &e[column.clone()]);
        turn_back(parts, grad, before);
        divide_back(parts, &x[column.clone()], T::if_less(zero, pivot, pivot, one), grad, before);
        add_scaled(&mut grad_x[column], one, grad);
    }
}

/// Moves the parts of grad_j along an earlier e_k to grad_k.
///
/// The e's stay orthogonal, so e_k . de_j = -e_j . de_k. Going through r_j instead would divide
/// these parts by a small pivot, only for them to cancel later.
#[inline(always)]
fn turn_back<T: Number>((earlier, e): (&[T], &[T]), grad: &mut [T], before: &mut [T]) {
    for (earlier, before) in earlier.chunks_exact(e.len()).zip(before.chunks_exact_mut(e.len())) {
        let along = over(dot(grad, earlier), e.len());
        subtract_scaled(grad, along, earlier);
        subtract_scaled(before, along, e);
    }
}

/// From the gradient of e_j = r_j / L_jj to that of r_j = x_j - sum_k L_jk e_k, and on to the e_k.
#[inline(always)]
fn divide_back<T: Number>(
    (earlier, e): (&[T], &[T]),
    column: &[T],
    pivot: T,
    grad: &mut [T],
    before: &mut [T],
) {
    let along = over(dot(grad, e), e.len());
    subtract_scaled(grad, along, e);
    divide(grad, pivot);
    for (earlier, before) in earlier.chunks_exact(e.len()).zip(before.chunks_exact_mut(e.len())) {
        subtract_scaled(before, over(dot(column, earlier), e.len()), grad);
    }
}

/// y <- y - a x
#[inline(always)]
fn subtract_scaled<T: Number>(y: &mut [T], a: T, x: &[T]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y = *y - a * x;
    }
}
