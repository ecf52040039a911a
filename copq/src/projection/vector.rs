//! The few operations on vectors that the projections are made of, for one row or for several at
//! once.

use super::number::Number;

/// a . b
#[inline(always)]
pub(super) fn dot<T: Number>(a: &[T], b: &[T]) -> T {
    sum(a.iter().zip(b).map(|(&a, &b)| a * b))
}

/// From left to right; -0 is what leaves every first term as it is.
#[inline(always)]
pub(super) fn sum<T: Number>(terms: impl Iterator<Item = T>) -> T {
    let mut sum = T::all(-0.0);
    for term in terms {
        sum = sum + term;
    }
    sum
}

/// y <- y + a x
#[inline(always)]
pub(super) fn add_scaled<T: Number>(y: &mut [T], a: T, x: &[T]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y = *y + a * x;
    }
}

/// The arithmetic mean.
#[inline(always)]
pub(super) fn mean<T: Number>(x: &[T]) -> T {
    over(sum(x.iter().copied()), x.len())
}

/// Subtracts the mean, and returns it.
#[inline(always)]
pub(super) fn centre<T: Number>(x: &mut [T]) -> T {
    let mean = mean(x);
    for x in x.iter_mut() {
        *x = *x - mean;
    }
    mean
}

/// sqrt(x . x / len): the biased standard deviation if x is centred.
#[inline(always)]
pub(super) fn rms<T: Number>(x: &[T]) -> T {
    // The division stays inside the root: for x = (-h, h) the result is then |h| to the bit.
    over(dot(x, x), x.len()).sqrt()
}

/// x <- x / |x|; a zero vector stays zero.
#[inline(always)]
pub(super) fn normalise<T: Number>(x: &mut [T]) {
    let length = dot(x, x).sqrt();
    let zero = T::all(0.0);
    divide(x, T::if_less(zero, length, length, T::all(1.0)));
}

/// x <- x / a
#[inline(always)]
pub(super) fn divide<T: Number>(x: &mut [T], a: T) {
    for x in x.iter_mut() {
        *x = *x / a;
    }
}

/// x / n
#[inline(always)]
pub(super) fn over<T: Number>(x: T, n: usize) -> T {
    // The reciprocal of a power of two is exact: the same bits, without a division.
    if n.is_power_of_two() { x * T::all(1.0 / n as f64) } else { x / T::all(n as f64) }
}
