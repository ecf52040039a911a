//! Working memory of projections: it grows to what a batch needs, and is then reused.

use std::mem;

use super::preconditioned::Factors;
use super::row::Row;

/// Working memory of a projection, and what the last
/// [`Projection::project`](super::Projection::project) reported.
///
/// Keep one for each place that calls a projection. Once it has seen a shape, that shape needs no
/// allocation.
///
/// ```
/// use copq::projection::{BoundQuery, Cholesky, Projection, QView, Scratch};
///
/// let mut scratch = Scratch::default();
/// let mut low = [0.0; 4];
/// // Two rows: in the first the critics disagree in opposite ways about the two objectives, in the
/// // second in the same way.
/// let q = QView::new(&[1.0, -1.0, 1.0, 1.0, -1.0, 4.0, -1.0, -1.0], 2, 2)?;
/// Cholesky.project(BoundQuery { q, weights: &[1.0, 1.0], step: -1.0 }, &mut scratch, &mut low)?;
/// assert_eq!(scratch.clip_rate(), 0.5);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    row: Row,
    work: Work,
    clips: usize,
    projected: usize,
}

impl Scratch {
    /// The fraction of the last projected batch's rows in which the clip of a Cholesky bound fired
    /// (paper A.1-A.4); 0 for methods that have no clip.
    pub fn clip_rate(&self) -> f64 {
        self.clips as f64 / self.projected.max(1) as f64
    }

    /// Sets [`Scratch::clip_rate`]. A projection calls it once per batch, with `clips` = 0 if it
    /// has no clip.
    pub fn report_clips(&mut self, clips: usize, rows: usize) {
        self.clips = clips;
        self.projected = rows;
    }

    /// The current row and the buffers, both at once.
    pub(super) fn parts(&mut self) -> (&mut Row, &mut Work) {
        (&mut self.row, &mut self.work)
    }
}

/// Buffers for the arithmetic of one row.
#[derive(Clone, Debug, Default)]
pub struct Work {
    buffer: Vec<f64>,
    factors: Factors,
    clipped: bool,
}

impl Work {
    /// Separate zeroed buffers of the given lengths; the next call takes them back.
    ///
    /// ```
    /// let mut work = copq::projection::Work::default();
    /// let [matrix, vector] = work.split([9, 3]);
    /// assert_eq!((matrix.len(), vector.len()), (9, 3));
    /// ```
    pub fn split<const M: usize>(&mut self, lengths: [usize; M]) -> [&mut [f64]; M] {
        self.split_beside(lengths).0
    }

    /// The same, together with the memory for factors of many objectives.
    pub(super) fn split_beside<const M: usize>(
        &mut self,
        lengths: [usize; M],
    ) -> ([&mut [f64]; M], &mut Factors) {
        self.buffer.clear();
        self.buffer.resize(lengths.iter().sum(), 0.0);
        let mut rest = self.buffer.as_mut_slice();
        let buffers = lengths.map(|length| {
            let (head, tail) = mem::take(&mut rest).split_at_mut(length);
            rest = tail;
            head
        });
        (buffers, &mut self.factors)
    }

    /// Reports that the clip fired in this row.
    pub fn report_clip(&mut self) {
        self.clipped = true;
    }

    /// Whether the clip has fired since the last call.
    pub(super) fn take_clip(&mut self) -> bool {
        mem::take(&mut self.clipped)
    }
}
