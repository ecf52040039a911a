//! Observations in units of their own spread: a running mean and standard deviation of every
//! component.

use crate::error::check_len;
use crate::{Error, Result, State};

/// Running mean and standard deviation of observations, component by component, in f64.
///
/// `clamp((x - mean) / max(std, 0.01), -5, 5)`, with the deviation over n - 1 (OmniSafe's
/// normaliser). Fewer than two observations have no deviation: then a value is left as it is.
///
/// ```
/// use copq::Normaliser;
///
/// let mut normaliser = Normaliser::new(1);
/// for x in [1.0, 2.0, 3.0] {
///     normaliser.push(&[x])?;
/// }
/// let mut obs = [4.0, 1.0]; // a batch of two
/// normaliser.normalise(&mut obs)?;
/// assert_eq!(obs, [2.0, -1.0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Normaliser {
    count: u64,
    mean: Vec<f64>,
    /// Sums of squared distances from the mean.
    squares: Vec<f64>,
    /// One over the deviations, computed from the squares.
    scale: Vec<f64>,
    /// The number of components after these, which are left as they are.
    raw: usize,
}

impl Normaliser {
    /// The smallest standard deviation that an observation is divided by.
    pub const SMALLEST_STD: f64 = 0.01;
    /// The largest size of a normalised value.
    pub const CLIP: f64 = 5.0;

    /// A normaliser that has seen nothing, for observations of this length.
    pub fn new(observation: usize) -> Self {
        let zeros = vec![0.0; observation];
        Self { count: 0, mean: zeros.clone(), squares: zeros.clone(), scale: zeros, raw: 0 }
    }

    /// For observations with `raw` more components at their end, which are left as they are.
    pub fn and_raw(self, raw: usize) -> Self {
        Self { raw, ..self }
    }

    /// Takes in one observation.
    pub fn push(&mut self, obs: &[f32]) -> Result<()> {
        check_len("observation", obs.len(), self.mean.len() + self.raw)?;
        self.count += 1;
        let share = 1.0 / self.count as f64;
        for ((mean, squares), &x) in self.mean.iter_mut().zip(&mut self.squares).zip(obs) {
            let distance = f64::from(x) - *mean;
            *mean += share * distance;
            *squares += distance * (f64::from(x) - *mean);
        }
        self.rescale();
        Ok(())
    }

    fn rescale(&mut self) {
        let n = self.count as f64 - 1.0;
        for (scale, squares) in self.scale.iter_mut().zip(&self.squares) {
            *scale = 1.0 / (squares / n).sqrt().max(Self::SMALLEST_STD);
        }
    }

    /// Normalises a batch of observations, `rows x observation`, in place.
    pub fn normalise(&self, obs: &mut [f32]) -> Result<()> {
        let width = self.mean.len() + self.raw;
        if width == 0 || !obs.len().is_multiple_of(width) {
            return Err(Error::invalid(
                "observations",
                format!("a multiple of {width} values"),
                obs.len(),
            ));
        }
        if self.count < 2 {
            return Ok(());
        }
        for row in obs.chunks_exact_mut(width) {
            for ((x, mean), scale) in row.iter_mut().zip(&self.mean).zip(&self.scale) {
                *x = ((f64::from(*x) - mean) * scale).clamp(-Self::CLIP, Self::CLIP) as f32;
            }
        }
        Ok(())
    }

    /// The normaliser of a saved agent for observations of this length, if it has one.
    pub(crate) fn of(agent: &State, observation: usize) -> Result<Option<Self>> {
        let Ok(state) = agent.child("normaliser") else { return Ok(None) };
        let raw = state.get_one::<u64>("raw").unwrap_or(0) as usize;
        let mut normaliser = Self::new(observation.saturating_sub(raw)).and_raw(raw);
        normaliser.load(state)?;
        Ok(Some(normaliser))
    }

    /// Restores the normaliser of a saved agent; an error if only one side has one.
    pub(crate) fn restore(normaliser: &mut Option<Self>, agent: &State) -> Result<()> {
        match (normaliser, agent.child("normaliser")) {
            (Some(normaliser), saved) => normaliser.load(saved?),
            (None, Ok(_)) => {
                Err(Error::invalid("saved agent", "one without a normaliser", "one with it"))
            }
            (None, Err(_)) => Ok(()),
        }
    }

    /// Writes what it has seen.
    pub fn save(&self, state: &mut State) {
        state.put("count", [self.count]);
        if self.raw > 0 {
            state.put("raw", [self.raw as u64]);
        }
        state.put("mean", self.mean.as_slice());
        state.put("squares", self.squares.as_slice());
    }

    /// Restores what [`Normaliser::save`] wrote.
    pub fn load(&mut self, state: &State) -> Result<()> {
        self.count = state.get_one("count")?;
        state.read("mean", &mut self.mean)?;
        state.read("squares", &mut self.squares)?;
        self.rescale();
        Ok(())
    }
}
