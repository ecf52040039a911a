//! Adam's constants and its step size, shared by both implementations.

/// Decay of the first moment (PyTorch's default).
pub(crate) const BETA1: f64 = 0.9;
/// Decay of the second moment.
pub(crate) const BETA2: f64 = 0.999;
/// Added to the square root of the second moment.
pub(crate) const EPSILON: f64 = 1e-8;

/// The learning rate of one step with its bias corrections (Kingma and Ba 2015, arranged as in
/// PyTorch): `parameter -= rate * m / (sqrt(v) / root + EPSILON)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Learning rate divided by the first moment's correction.
    pub rate: f64,
    /// Square root of the second moment's correction.
    pub root: f64,
}

impl Step {
    /// The `count`-th step, counted from 1.
    pub fn new(lr: f64, count: u64) -> Self {
        let correction = |beta| 1.0 - libm::pow(beta, count as f64);
        Self { rate: lr / correction(BETA1), root: libm::sqrt(correction(BETA2)) }
    }
}
