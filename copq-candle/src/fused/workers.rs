//! Running one task a critic, on the caller's thread or spread over a pool.

use copq::{Error, Result};
use rayon::ThreadPool;
use rayon::prelude::*;

use super::network::Network;

/// The threads that share the critics; each critic's numbers come from one thread, so their count changes no bit.
#[derive(Debug, Default)]
pub(super) struct Workers(Option<ThreadPool>);

impl Workers {
    /// `threads` of them; one means the caller's own.
    pub fn new(threads: usize) -> Result<Self> {
        if threads == 1 {
            return Ok(Self(None));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(Self(Some(pool.map_err(|e| Error::other("starting the critics' threads", e))?)))
    }

    /// Runs `task` on every network with its equal share of `chunks`.
    pub fn each(
        &self,
        networks: &mut [Network],
        chunks: &mut [f32],
        task: impl Fn(usize, &mut Network, &mut [f32]) + Sync,
    ) {
        let share = chunks.len() / networks.len();
        match &self.0 {
            None => {
                let pairs = networks.iter_mut().zip(chunks.chunks_exact_mut(share));
                pairs.enumerate().for_each(|(k, (network, chunk))| task(k, network, chunk));
            }
            Some(pool) => pool.install(|| {
                let pairs = networks.par_iter_mut().zip(chunks.par_chunks_exact_mut(share));
                pairs.enumerate().for_each(|(k, (network, chunk))| task(k, network, chunk));
            }),
        }
    }
}
