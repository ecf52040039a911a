//! From an ensemble of vector-valued critics to one confidence bound: K x B x N values in, B x N out.

use std::fmt::Debug;

use crate::{Error, Result};

/// A batch of critics' values: `critics x rows x objectives`, row-major.
#[derive(Clone, Copy, Debug)]
pub struct QView<'a> {
    values: &'a [f32],
    critics: usize,
    rows: usize,
    objectives: usize,
}

impl<'a> QView<'a> {
    /// Views a slice as `critics x rows x objectives`; the number of rows follows from its length.
    pub fn new(values: &'a [f32], critics: usize, objectives: usize) -> Result<Self> {
        let per_row = critics * objectives;
        if per_row == 0 || values.is_empty() || !values.len().is_multiple_of(per_row) {
            let wanted = format!("a positive multiple of {critics} critics x {objectives} objectives");
            return Err(Error::invalid("critic values", wanted, values.len()));
        }
        Ok(Self { values, critics, rows: values.len() / per_row, objectives })
    }

    /// K, the number of critics.
    pub fn critics(&self) -> usize {
        self.critics
    }

    /// B, the number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// N, the number of objectives.
    pub fn objectives(&self) -> usize {
        self.objectives
    }

    /// All values, `critics x rows x objectives`.
    pub fn values(&self) -> &'a [f32] {
        self.values
    }

    /// The N values of one critic in one row.
    pub fn get(&self, critic: usize, row: usize) -> &'a [f32] {
        let start = (critic * self.rows + row) * self.objectives;
        &self.values[start..start + self.objectives]
    }
}

/// Working memory of a projection; it grows to what a batch needs and is then reused.
#[derive(Clone, Debug, Default)]
pub struct Scratch {}

/// A rule that turns the critics' disagreement into one vector a row: `mean + step * offset` for ellipsoid methods.
///
/// `weights` are the raw scalarisation weights, one an objective (`N`) or one set a row (`B x N`); the unit direction is
/// made inside, and a zero or non-finite direction is an error. `step` is signed: -1 is the lower bound of the TD
/// target and the actor (paper eq. 11), 0 the mean, +beta the upper bound that explores (eq. 12).
pub trait Projection: Debug + Send + Sync {
    /// The name by which command lines and logs know the method.
    fn name(&self) -> &'static str;

    /// Critics that the method is meant to be used with, for N objectives; N + 1 unless it says otherwise.
    fn critics(&self, objectives: usize) -> usize {
        objectives + 1
    }

    /// Writes the bound, `rows x objectives`, into `out`.
    fn project(&self, q: QView<'_>, weights: &[f32], step: f32, scratch: &mut Scratch, out: &mut [f32]) -> Result<()>;

    /// Writes d(grad_out . bound)/dq, laid out like `q`, into `grad_q`; weights are constants.
    fn vjp(
        &self,
        q: QView<'_>,
        weights: &[f32],
        step: f32,
        scratch: &mut Scratch,
        grad_out: &[f32],
        grad_q: &mut [f32],
    ) -> Result<()>;
}
