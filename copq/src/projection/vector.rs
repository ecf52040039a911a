//! The few operations on vectors that the projections are made of.

/// a . b
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// y <- y + a x
pub(super) fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// The arithmetic mean.
pub(super) fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// Subtracts the mean, and returns it.
pub(super) fn centre(x: &mut [f64]) -> f64 {
    let mean = mean(x);
    x.iter_mut().for_each(|x| *x -= mean);
    mean
}

/// sqrt(x . x / len): the biased standard deviation if x is centred.
pub(super) fn rms(x: &[f64]) -> f64 {
    // The division stays inside the root: for x = (-h, h) the result is then |h| to the bit.
    (dot(x, x) / x.len() as f64).sqrt()
}

/// x <- x / |x|; a zero vector stays zero.
pub(super) fn normalise(x: &mut [f64]) {
    let length = dot(x, x).sqrt();
    if length > 0.0 {
        x.iter_mut().for_each(|x| *x /= length);
    }
}
