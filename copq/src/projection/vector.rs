//! The few operations on vectors that the projections are made of.

/// a . b
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    sum(a.iter().zip(b).map(|(&a, &b)| a * b))
}

/// Adds from left to right; starting from -0 leaves every first term as it is.
pub(super) fn sum(terms: impl Iterator<Item = f64>) -> f64 {
    let mut sum = -0.0;
    for term in terms {
        sum += term;
    }
    sum
}

/// y <- y + a x
pub(super) fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// y <- y - a x
pub(super) fn subtract_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y -= a * x;
    }
}

/// The arithmetic mean.
pub(super) fn mean(x: &[f64]) -> f64 {
    over(sum(x.iter().copied()), x.len())
}

/// Subtracts the mean, and returns it.
pub(super) fn centre(x: &mut [f64]) -> f64 {
    let mean = mean(x);
    for x in x.iter_mut() {
        *x -= mean;
    }
    mean
}

/// sqrt(x . x / len): the biased standard deviation if x is centred.
pub(super) fn rms(x: &[f64]) -> f64 {
    // The division stays inside the root: for x = (-h, h) the result is then |h| to the bit.
    over(dot(x, x), x.len()).sqrt()
}

/// x <- x / |x|; a zero vector stays zero.
pub(super) fn normalise(x: &mut [f64]) {
    let length = dot(x, x).sqrt();
    if length > 0.0 {
        divide(x, length);
    }
}

/// x <- x / a
pub(super) fn divide(x: &mut [f64], a: f64) {
    for x in x.iter_mut() {
        *x /= a;
    }
}

/// x / n
pub(super) fn over(x: f64, n: usize) -> f64 {
    // The reciprocal of a power of two is exact: the same bits, without a division.
    if n.is_power_of_two() { x * (1.0 / n as f64) } else { x / n as f64 }
}
