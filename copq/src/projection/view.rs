//! The critics' values of a batch, as a read-only view: K critics x B rows x N objectives.

use std::ops::Range;

use crate::{Error, Result};

/// A batch of critics' values: `critics x rows x objectives`, row-major.
///
/// ```
/// use copq::QView;
///
/// // Two critics, two rows, two objectives.
/// let q = QView::new(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], 2, 2)?;
/// assert_eq!(q.rows(), 2);
/// assert_eq!(q.get(1, 0), [5.0, 6.0]); // the second critic in the first row
/// # Ok::<(), copq::Error>(())
/// ```
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
            let wanted =
                format!("a positive multiple of {critics} critics x {objectives} objectives");
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
        &self.values[self.range(critic, row)]
    }

    /// Where [`QView::get`] finds its values, in `values` and in a gradient with the same layout.
    pub fn range(&self, critic: usize, row: usize) -> Range<usize> {
        let start = (critic * self.rows + row) * self.objectives;
        start..start + self.objectives
    }
}
