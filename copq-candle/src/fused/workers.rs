//! Running one task a critic, on the caller's thread or spread over a pool.

use copq::{Error, Result};
use rayon::ThreadPool;
use rayon::prelude::*;

use super::network::Network;
use super::workspace::Workspace;

/// The threads that share the critics; each critic's numbers come from one thread, so their count changes no bit.
#[derive(Debug)]
pub(super) struct Workers {
    pool: Option<ThreadPool>,
    /// One a thread.
    workspaces: Vec<Workspace>,
}

impl Workers {
    /// `threads` of them; one means the caller's own.
    pub fn new(threads: usize) -> Result<Self> {
        let pool = || rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = (threads > 1).then(pool).transpose();
        let pool = pool.map_err(|e| Error::other("starting the critics' threads", e))?;
        Ok(Self { pool, workspaces: vec![Workspace::default(); threads] })
    }

    /// That of the caller's thread.
    pub fn workspace(&mut self) -> &mut Workspace {
        &mut self.workspaces[0] // There is at least one thread.
    }

    /// Runs `task` on every network with its equal share of `chunks`.
    pub fn each(
        &mut self,
        networks: &mut [Network],
        chunks: &mut [f32],
        task: impl Fn(usize, &mut Network, &mut [f32], &mut Workspace) + Sync,
    ) {
        let (count, share) = (networks.len().div_ceil(self.workspaces.len()), chunks.len() / networks.len());
        let some = |first: usize, networks: &mut [Network], chunks: &mut [f32], workspace: &mut Workspace| {
            for (k, (network, chunk)) in (first..).zip(networks.iter_mut().zip(chunks.chunks_exact_mut(share))) {
                task(k, network, chunk, workspace);
            }
        };
        match &self.pool {
            None => some(0, networks, chunks, &mut self.workspaces[0]),
            Some(pool) => pool.install(|| {
                let parts = networks.par_chunks_mut(count).zip(chunks.par_chunks_mut(count * share));
                let parts = parts.zip(&mut self.workspaces).enumerate();
                parts.for_each(|(i, ((networks, chunks), workspace))| some(i * count, networks, chunks, workspace));
            }),
        }
    }
}
