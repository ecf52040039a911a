//! The clipping rotation R of paper A.1-A.4 in closed form: it keeps a lower bound from lying above
//! the mean.

use super::vector::{dot, normalise, sum};

/// Writes R u, given p = L'u; returns whether the clip fired, that is whether a = u . p < 0.
///
/// Then R u is the unit vector nearest to u that is orthogonal to p, so that u . L R u = 0. If the
/// clip does not fire, R u = u. (If a is below zero, then p != 0 and p is not parallel to u,
/// because L is triangular and its diagonal is not negative.)
pub(super) fn rotate(u: &[f64], p: &[f64], out: &mut [f64]) -> bool {
    let fired = dot(u, p) < 0.0;
    if fired {
        reject(u, p, out);
        normalise(out);
    } else {
        out.copy_from_slice(u);
    }
    fired
}

/// Writes u - (a / p.p) p as a sum of 2 x 2 minors, in which nothing cancels when u and p are
/// almost parallel.
fn reject(u: &[f64], p: &[f64], out: &mut [f64]) {
    let square = dot(p, p);
    for (i, out) in out.iter_mut().enumerate() {
        let minors = u.iter().zip(p).map(|(&u_j, &p_j)| p_j * (p_j * u[i] - p[i] * u_j));
        *out = sum(minors) / square;
    }
}

/// Writes d(grad . R u)/dp for a clip that fired and gave `rotated`; u is constant.
///
/// With t = u - c p and c = a / p.p: R u = t / |t|, and |t| = u . R u because t is orthogonal to p.
pub(super) fn rotate_vjp(u: &[f64], p: &[f64], rotated: &[f64], grad: &[f64], out: &mut [f64]) {
    let length = dot(u, rotated);
    let square = dot(p, p);
    let c = dot(u, p) / square;
    let along = dot(grad, rotated);
    let grad_c = -dot(grad, p) / length;
    for (i, out) in out.iter_mut().enumerate() {
        let grad_t = (grad[i] - along * rotated[i]) / length;
        *out = grad_c * (u[i] - 2.0 * c * p[i]) / square - c * grad_t;
    }
}
