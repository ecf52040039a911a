//! The random disturbance of an initial state.

use copq::Rng;

/// A distribution around zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// Uniform on [-scale, scale).
    Uniform(f64),
    /// Normal with this standard deviation.
    Gaussian(f64),
}

impl Noise {
    /// Draws one number.
    pub fn draw(self, rng: &mut Rng) -> f64 {
        match self {
            Self::Uniform(scale) => rng.uniform_in(-scale, scale),
            Self::Gaussian(deviation) => deviation * rng.normal(),
        }
    }
}
