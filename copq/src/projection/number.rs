//! What the arithmetic of a row is written in: one row's number, or several rows' numbers side by
//! side.

use std::ops::{Add, Div, Mul, Sub};

/// A real number in double precision, once (`f64`) or once for each of several rows
/// ([`Lanes`](super::lanes::Lanes)).
///
/// Rows never meet: every operation does to each row what it does to a single one, so the results
/// are the same bits.
pub(super) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// How many rows.
    const ROWS: usize;

    /// The number of every row, given its position.
    fn from_rows(value: impl Fn(usize) -> f64) -> Self;

    /// The number of one row.
    fn row(self, row: usize) -> f64;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// `yes` in the rows where a < b, `no` in the others.
    fn if_less(a: Self, b: Self, yes: Self, no: Self) -> Self;

    /// The same number in all rows.
    #[inline(always)]
    fn all(value: f64) -> Self {
        Self::from_rows(|_| value)
    }

    /// The sum over the rows.
    #[inline(always)]
    fn total(self) -> f64 {
        (0..Self::ROWS).map(|row| self.row(row)).sum()
    }
}

impl Number for f64 {
    const ROWS: usize = 1;

    #[inline(always)]
    fn from_rows(value: impl Fn(usize) -> f64) -> Self {
        value(0)
    }

    #[inline(always)]
    fn row(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn if_less(a: Self, b: Self, yes: Self, no: Self) -> Self {
        if a < b { yes } else { no }
    }
}
