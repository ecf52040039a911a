//! Every random number of a run: ChaCha8 streams, one for each purpose, whose position can be
//! saved.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng};

use crate::{Error, Result, State};

/// What a stream of random numbers is for; streams of one seed never overlap.
///
/// ```
/// use copq::{Rng, Stream};
///
/// let mut explore = Rng::new(7, Stream::Explore);
/// let mut batch = Rng::new(7, Stream::Batch);
/// assert_ne!(explore.next_u64(), batch.next_u64());
/// assert_eq!(Rng::new(7, Stream::Batch).next_u64(), Rng::new(7, Stream::Batch).next_u64());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
#[non_exhaustive]
pub enum Stream {
    /// Initial network weights.
    Init = 0,
    /// Exploration noise, and the uniform actions of the warm-up.
    Explore = 1,
    /// Noise inside an update: target smoothing, a stochastic policy's samples.
    Smoothing = 2,
    /// Which transitions make up a batch.
    Batch = 3,
    /// Which critics make up a subset (REDQ).
    Subset = 4,
    /// Episode seeds of the training environment.
    Env = 5,
    /// Episode seeds of the evaluation environment.
    Evaluation = 6,
    /// Noise of the policy whose [`coverage()`](crate::coverage()) is measured.
    Coverage = 7,
    /// For your own use, such as an environment's noise, from its episode's seed.
    Custom = 100,
}

/// A seeded generator that can be saved. Its distributions are copq's own, so that no update of
/// another crate changes a run.
///
/// ```
/// use copq::{Rng, State, Stream};
///
/// let mut wind = Rng::new(7, Stream::Custom);
/// let mut state = State::default();
/// wind.save("wind", &mut state);
/// let gust = wind.normal();
///
/// wind.load("wind", &state)?; // back to where it was
/// assert_eq!(wind.normal(), gust);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rng(ChaCha8Rng);

impl Rng {
    /// The stream of `seed` for one purpose.
    pub fn new(seed: u64, stream: Stream) -> Self {
        Self::with_stream(seed, stream as u64)
    }

    /// A stream by number, for more purposes than [`Stream::Custom`]. The numbers from 101 to 999
    /// are yours.
    pub fn with_stream(seed: u64, stream: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(stream);
        Self(rng)
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform on [0, 1), 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform on [low, high).
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform on 0..n; n must be positive.
    pub fn below(&mut self, n: usize) -> usize {
        debug_assert!(n > 0);
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }

    /// Two independent standard normals (Box-Muller).
    pub fn normal_pair(&mut self) -> (f64, f64) {
        // 1 - uniform is in (0, 1], so the logarithm is finite.
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * self.uniform());
        (radius * cos, radius * sin)
    }

    /// One standard normal.
    pub fn normal(&mut self) -> f64 {
        self.normal_pair().0
    }

    /// Fills `out` with standard normals.
    pub fn fill_normal(&mut self, out: &mut [f32]) {
        for pair in out.chunks_mut(2) {
            let (first, second) = self.normal_pair();
            pair[0] = first as f32;
            if let Some(last) = pair.get_mut(1) {
                *last = second as f32;
            }
        }
    }

    /// Writes the generator's exact position under `name`.
    pub fn save(&self, name: &str, state: &mut State) {
        let mut bytes = Vec::with_capacity(56);
        bytes.extend(self.0.get_seed());
        bytes.extend(self.0.get_stream().to_le_bytes());
        bytes.extend(self.0.get_word_pos().to_le_bytes());
        state.put(name, bytes);
    }

    /// Restores the position that [`Rng::save`] wrote under `name`.
    pub fn load(&mut self, name: &str, state: &State) -> Result<()> {
        let bytes: &[u8] = state.get(name)?;
        let bytes: &[u8; 56] = bytes.try_into().map_err(|_| {
            Error::invalid(format!("saved generator '{name}'"), "56 bytes", bytes.len())
        })?;
        let (key, rest) = bytes.split_at(32);
        let (stream, position) = rest.split_at(8);
        let sized = "split_at above gives exactly this length";
        let mut rng = ChaCha8Rng::from_seed(key.try_into().expect(sized));
        rng.set_stream(u64::from_le_bytes(stream.try_into().expect(sized)));
        rng.set_word_pos(u128::from_le_bytes(position.try_into().expect(sized)));
        self.0 = rng;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn streams_differ_and_a_restored_stream_goes_on_exactly() {
        let mut a = Rng::new(7, Stream::Explore);
        let mut b = Rng::new(7, Stream::Batch);
        assert_ne!(a.next_u64(), b.next_u64());
        a.normal();
        let mut state = State::default();
        a.save("rng", &mut state);
        let mut restored = Rng::new(0, Stream::Init);
        restored.load("rng", &state).unwrap();
        assert!((0..100).all(|_| a.next_u64() == restored.next_u64()));
    }

    #[test]
    fn moments_of_the_distributions() {
        let mut rng = Rng::new(1, Stream::Smoothing);
        let mut draws = vec![0.0; 200_001];
        rng.fill_normal(&mut draws);
        let n = draws.len() as f64;
        let mean = draws.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
        let variance = draws.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>() / n;
        let fourth = draws.iter().map(|&x| f64::from(x).powi(4)).sum::<f64>() / n;
        assert_abs_diff_eq!(mean, 0.0, epsilon = 0.01);
        assert_abs_diff_eq!(variance, 1.0, epsilon = 0.02);
        assert_abs_diff_eq!(fourth, 3.0, epsilon = 0.1);
        let mut counts = [0; 7];
        (0..70_000).for_each(|_| counts[rng.below(7)] += 1);
        assert!(counts.iter().all(|&c| (9_500..10_500).contains(&c)), "{counts:?}");
        assert!((0..1000).all(|_| (-2.0..3.0).contains(&rng.uniform_in(-2.0, 3.0))));
    }
}
