//! The random numbers of a learner, with one stream for each purpose.

use crate::{Result, Rng, State, Stream};

/// One generator for each purpose, so that drawing from one does not move the others.
#[derive(Debug)]
pub(super) struct Streams {
    pub(super) explore: Rng,
    pub(super) smoothing: Rng,
    pub(super) batch: Rng,
    pub(super) subset: Rng,
}

impl Streams {
    /// The streams of a seed.
    pub(super) fn new(seed: u64) -> Self {
        Self {
            explore: Rng::new(seed, Stream::Explore),
            smoothing: Rng::new(seed, Stream::Smoothing),
            batch: Rng::new(seed, Stream::Batch),
            subset: Rng::new(seed, Stream::Subset),
        }
    }

    /// Writes every stream's position.
    pub(super) fn save(&self, state: &mut State) {
        self.explore.save("rng_explore", state);
        self.smoothing.save("rng_smoothing", state);
        self.batch.save("rng_batch", state);
        self.subset.save("rng_subset", state);
    }

    /// Restores what [`Streams::save`] wrote.
    pub(super) fn load(&mut self, state: &State) -> Result<()> {
        self.explore.load("rng_explore", state)?;
        self.smoothing.load("rng_smoothing", state)?;
        self.batch.load("rng_batch", state)?;
        self.subset.load("rng_subset", state)
    }
}
