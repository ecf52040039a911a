//! The random disturbance of an initial state.

use copq::Rng;

/// A distribution around zero.
///
/// ```
/// use copq::{Rng, Stream};
/// use copq_envs::robot::Noise;
///
/// let mut rng = Rng::new(0, Stream::Custom);
/// assert!(Noise::Uniform(0.005).draw(&mut rng).abs() <= 0.005);
/// assert_eq!(Noise::Gaussian(0.0).draw(&mut rng), 0.0);
/// ```
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
