//! A batch as ellipsoids see it: one row after the other, or several at a time.

use std::ops::Range;

use super::number::Number;
use super::row::Row;
use super::{Bound, Directions};

/// A checked [`Bound`].
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    pub(super) bound: Bound<'a>,
    pub(super) directions: Directions<'a>,
}

impl Batch<'_> {
    /// As many of the rows as fill whole `T`s.
    pub(super) fn whole<T: Number>(&self) -> usize {
        self.bound.q.rows() / T::ROWS * T::ROWS
    }

    /// Writes the bounds of `rows`, a multiple of `T::ROWS`; returns in how many the clip fired.
    ///
    /// `offset` is given X and u, writes the offset, and returns 1 where the clip fired, else 0.
    #[inline(always)]
    pub(super) fn project<T: Number>(
        &self,
        rows: Range<usize>,
        line: &mut Row<T>,
        out: &mut [f32],
        mut offset: impl FnMut(&[T], &[T], &mut [T]) -> T,
    ) -> usize {
        let Bound { q, step, .. } = self.bound;
        let mut clips = T::all(0.0);
        line.resize(q);
        for row in rows.clone().step_by(T::ROWS) {
            self.load(row, row == rows.start, line);
            clips = clips + offset(&line.deviations, &line.unit, &mut line.offset);
            line.write_bound(row, step.into(), out);
        }
        clips.total() as usize
    }

    /// Writes the gradients of `rows`, a multiple of `T::ROWS`.
    ///
    /// `offset_vjp` is given X, u and the offset's gradient, and adds to X's, which is zero before.
    #[inline(always)]
    pub(super) fn vjp<T: Number>(
        &self,
        rows: Range<usize>,
        line: &mut Row<T>,
        (grad_out, grad_q): (&[f32], &mut [f32]),
        mut offset_vjp: impl FnMut(&[T], &[T], &[T], &mut [T]),
    ) {
        let Bound { q, step, .. } = self.bound;
        line.resize(q);
        for row in rows.clone().step_by(T::ROWS) {
            self.load(row, row == rows.start, line);
            line.load_grad(row, grad_out);
            offset_vjp(&line.deviations, &line.unit, &line.grad, &mut line.grad_x);
            line.write_grad(q, row, step.into(), grad_q);
        }
    }

    /// One set of weights has one direction, found with the first row.
    #[inline(always)]
    fn load<T: Number>(&self, row: usize, first: bool, line: &mut Row<T>) {
        if first || !self.directions.shared() {
            line.load_unit(row, &self.directions);
        }
        line.load(self.bound.q, row);
    }
}
