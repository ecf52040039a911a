//! Scalarisation weights and the unit directions they stand for.

use super::vector::normalise;
use crate::{Error, Result};

/// Checked scalarisation weights: one set for the whole batch, or one set per row.
///
/// ```
/// use copq::projection::Directions;
///
/// // One set of two weights, for a batch of four rows.
/// let directions = Directions::new(&[3.0, 4.0], 4, 2)?;
/// let mut u = [0.0; 2];
/// directions.unit(3, &mut u);
/// assert_eq!(u, [0.6, 0.8]);
/// assert!(Directions::new(&[0.0, 0.0], 4, 2).is_err()); // no direction
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Directions<'a> {
    weights: &'a [f32],
    objectives: usize,
    rows: usize,
}

impl<'a> Directions<'a> {
    /// Checks `objectives` or `rows x objectives` weights: finite, and no set of them all zero.
    pub fn new(weights: &'a [f32], rows: usize, objectives: usize) -> Result<Self> {
        check_length(weights.len(), rows, objectives)?;
        for (row, weights) in weights.chunks_exact(objectives).enumerate() {
            check_set(weights, row)?;
        }
        Ok(Self { weights, objectives, rows: weights.len() / objectives })
    }

    /// The weights of one row, as they were given.
    pub fn weights(&self, row: usize) -> &'a [f32] {
        let start = if self.rows == 1 { 0 } else { row * self.objectives };
        &self.weights[start..start + self.objectives]
    }

    /// Whether all rows have the same weights.
    pub(super) fn shared(&self) -> bool {
        self.rows == 1
    }

    /// Writes the unit direction u = w / |w| of one row (paper eq. 2).
    pub fn unit(&self, row: usize, u: &mut [f64]) {
        for (u, &weight) in u.iter_mut().zip(self.weights(row)) {
            *u = f64::from(weight);
        }
        normalise(u);
    }
}

fn check_length(got: usize, rows: usize, objectives: usize) -> Result<()> {
    if objectives > 0 && (got == objectives || got == rows * objectives) {
        return Ok(());
    }
    let per_row = rows * objectives;
    let wanted = format!(
        "{objectives} values (one per objective) or {per_row} (one set for each of {rows} rows)"
    );
    Err(Error::invalid("scalarisation weights", wanted, got))
}

fn check_set(weights: &[f32], row: usize) -> Result<()> {
    if let Some(i) = weights.iter().position(|w| !w.is_finite()) {
        let what = format!("scalarisation weight of objective {i} in set {row}");
        return Err(Error::invalid(what, "a finite number", weights[i]));
    }
    if weights.iter().all(|&w| w == 0.0) {
        let what = format!("scalarisation weights in set {row}");
        return Err(Error::invalid(what, "at least one that is not zero", "only zeros"));
    }
    Ok(())
}
