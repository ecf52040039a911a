//! The checks that every projection makes before it computes anything.

use super::{Directions, QView};
use crate::error::check_len;
use crate::{Error, Result};

/// Checks what [`Projection::project`](super::Projection::project) was given, and returns the directions in `weights`.
pub fn check_project<'a>(q: QView<'_>, weights: &'a [f32], step: f32, out: &[f32]) -> Result<Directions<'a>> {
    check_step(step)?;
    check_len("bound", out.len(), q.rows() * q.objectives())?;
    Directions::new(weights, q.rows(), q.objectives())
}

/// Checks what [`Projection::vjp`](super::Projection::vjp) was given, and returns the directions in `weights`.
pub fn check_vjp<'a>(
    q: QView<'_>,
    weights: &'a [f32],
    step: f32,
    grad_out: &[f32],
    grad_q: &[f32],
) -> Result<Directions<'a>> {
    check_step(step)?;
    check_len("gradient of the bound", grad_out.len(), q.rows() * q.objectives())?;
    check_len("gradient of the critic values", grad_q.len(), q.values().len())?;
    Directions::new(weights, q.rows(), q.objectives())
}

fn check_step(step: f32) -> Result<()> {
    if step.is_finite() { Ok(()) } else { Err(Error::invalid("step of the bound", "a finite number", step)) }
}
