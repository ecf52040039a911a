//! The clipping rotation R of paper A.1-A.4 in closed form: it keeps a lower bound from lying above
//! the mean.

use super::number::Number;
use super::vector::{dot, normalise, sum};

/// Writes R u, given p = L'u; returns 1 where the clip fired, that is where a = u . p < 0, and 0
/// elsewhere.
///
/// Then R u is the unit vector nearest to u that is orthogonal to p, so that u . L R u = 0. Where
/// the clip does not fire, R u = u. (An a below zero implies p != 0 and p not parallel to u: L is
/// triangular, its diagonal not negative.)
#[inline(always)]
pub(super) fn turn<T: Number>(u: &[T], p: &[T], out: &mut [T]) -> T {
    let a = dot(u, p);
    let zero = T::all(0.0);
    let fired = T::if_less(a, zero, T::all(1.0), zero);
    if fired.total() == 0.0 {
        out.copy_from_slice(u);
        return fired;
    }
    reject(u, p, out);
    normalise(out);
    for (out, &u) in out.iter_mut().zip(u) {
        *out = T::if_less(a, zero, *out, u);
    }
    fired
}

/// Writes u - (a / p.p) p as a sum of 2 x 2 minors, in which nothing cancels when u and p are
/// almost parallel.
#[inline(always)]
fn reject<T: Number>(u: &[T], p: &[T], out: &mut [T]) {
    let square = dot(p, p);
    for (i, out) in out.iter_mut().enumerate() {
        let minors = u.iter().zip(p).map(|(&u_j, &p_j)| p_j * (p_j * u[i] - p[i] * u_j));
        *out = sum(minors) / square;
    }
}

/// Writes d(grad . R u)/dp where the clip `fired` and gave `turned`, and 0 elsewhere; u is
/// constant.
///
/// With t = u - c p and c = a / p.p: R u = t / |t|, and |t| = u . R u because t is orthogonal to p.
#[inline(always)]
pub(super) fn turn_vjp<T: Number>(
    (u, p, turned): (&[T], &[T], &[T]),
    fired: T,
    grad: &[T],
    out: &mut [T],
) {
    let length = dot(u, turned);
    let square = dot(p, p);
    let zero = T::all(0.0);
    let c = dot(u, p) / square;
    let along = dot(grad, turned);
    let grad_c = zero - dot(grad, p) / length;
    for (i, out) in out.iter_mut().enumerate() {
        let grad_t = (grad[i] - along * turned[i]) / length;
        let grad_p = grad_c * (u[i] - T::all(2.0) * c * p[i]) / square - c * grad_t;
        *out = T::if_less(zero, fired, grad_p, zero);
    }
}
