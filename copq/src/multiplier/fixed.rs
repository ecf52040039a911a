//! Weights that never change.

use super::Multiplier;
use crate::projection::Directions;
use crate::{Error, Result};

/// Constant weights; the actor maximises along their unit direction (paper eq. 14).
///
/// ```
/// use copq::{FixedWeights, Multiplier};
///
/// let fixed = FixedWeights::new(&[3.0, 4.0])?;
/// assert_eq!(fixed.weights(), [3.0, 4.0]);
/// assert_eq!(fixed.actor_weights(), [0.6, 0.8]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FixedWeights {
    weights: Vec<f32>,
    direction: Vec<f64>,
}

impl FixedWeights {
    /// Weights that never change; all must be finite, and at least one non-zero.
    pub fn new(weights: &[f32]) -> Result<Self> {
        if weights.iter().any(|w| !w.is_finite()) || weights.iter().all(|&w| w == 0.0) {
            return Err(Error::invalid(
                "scalarisation weights",
                "finite numbers, not all zero",
                format!("{weights:?}"),
            ));
        }
        let mut direction = vec![0.0; weights.len()];
        Directions::new(weights, 1, weights.len())?.unit(0, &mut direction);
        Ok(Self { weights: weights.to_vec(), direction })
    }
}

impl Multiplier for FixedWeights {
    fn weights(&self) -> &[f32] {
        &self.weights
    }

    fn actor_weights(&self) -> &[f64] {
        &self.direction
    }

    fn is_constant(&self) -> bool {
        true
    }
}
