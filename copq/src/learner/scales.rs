//! Whether what comes in has a size that float32 networks can learn from.

use crate::{Error, Observer, Result};

/// Numbers beyond this learn badly: networks are made for inputs and values near 1.
pub(crate) const LARGE: f32 = 1e4;

/// Rewards beyond this cannot be learned: values are sums of many, and the squares of their
/// gradients, Adam's second moments, must stay below 3e38.
const HOPELESS: f32 = 1e15;

/// The largest sizes so far, and whether a word was said about them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scales {
    obs: f32,
    reward: f32,
    has_warned: bool,
}

impl Scales {
    /// Takes in what an environment returned; an error for what no network can learn.
    pub(crate) fn observe(&mut self, obs: &[f32], reward: &[f32]) -> Result<()> {
        let largest = size(reward);
        if largest > HOPELESS {
            let wanted = format!("at most {HOPELESS:e}, so that squares of values fit float32");
            return Err(Error::invalid("size of the rewards", wanted, format!("{largest:e}")));
        }
        self.obs = size(obs).max(self.obs);
        self.reward = largest.max(self.reward);
        Ok(())
    }

    /// Says once that sizes are larger than is good.
    pub(crate) fn warn(&mut self, step: u64, is_normalised: bool, log: &mut dyn Observer) {
        let obs = if is_normalised { 0.0 } else { self.obs };
        if self.has_warned || obs.max(self.reward) <= LARGE {
            return;
        }
        self.has_warned = true;
        if obs > LARGE {
            log.warn(step, &large_obs(obs));
        }
        if self.reward > LARGE {
            log.warn(step, &large_reward(self.reward));
        }
    }
}

pub(crate) fn size(values: &[f32]) -> f32 {
    values.iter().fold(0.0, |most, x| x.abs().max(most))
}

pub(crate) fn large_obs(size: f32) -> String {
    format!(
        "observations reach {size:.1e}, and networks learn from numbers near 1: scale them, or let \
         the method normalise them (Config::normalise)"
    )
}

pub(crate) fn large_reward(size: f32) -> String {
    format!("rewards reach {size:.1e}, and networks learn values near 1 to 1,000: scale them")
}
