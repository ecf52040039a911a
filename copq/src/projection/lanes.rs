//! Eight rows' numbers side by side: plain loops that the compiler turns into vector instructions.
//!
//! It does so where everything is inlined: hence the attributes wherever a [`Number`] is worked
//! with, and `for` loops rather than `fold` and `for_each`, whose closures it may leave functions
//! of their own, called for every sum.

use std::ops::{Add, Div, Mul, Sub};

use super::number::Number;

const LANES: usize = 8;

/// One number for each of eight rows, a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Lanes([f64; LANES]);

impl Lanes {
    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a = f(*a, b));
        self
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Lanes {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl Number for Lanes {
    const ROWS: usize = LANES;

    #[inline(always)]
    fn from_rows(value: impl Fn(usize) -> f64) -> Self {
        let mut lanes = [0.0; LANES];
        lanes.iter_mut().enumerate().for_each(|(row, lane)| *lane = value(row));
        Self(lanes)
    }

    #[inline(always)]
    fn row(self, row: usize) -> f64 {
        self.0[row]
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn if_less(a: Self, b: Self, yes: Self, mut no: Self) -> Self {
        for row in 0..LANES {
            no.0[row] = if a.0[row] < b.0[row] { yes.0[row] } else { no.0[row] };
        }
        no
    }
}
