//! A custom projection.

use copq::projection::{Deviations, Ellipsoid, Work};

/// Cautious about the first objective alone: u_0 standard deviations for safety, none for the rest.
#[derive(Debug)]
pub struct SafetyOnly;

impl Ellipsoid for SafetyOnly {
    fn name(&self) -> &'static str {
        "safety-only"
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], _: &mut Work, out: &mut [f64]) {
        out.fill(0.0);
        out[0] = x.std(0) * u[0];
    }

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        _: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        let scale = grad[0] * u[0] / (x.std(0).max(1e-12) * x.critics() as f64);
        for (x, grad_x) in x.objective(0).iter().zip(grad_x) {
            *grad_x += scale * x;
        }
    }
}
