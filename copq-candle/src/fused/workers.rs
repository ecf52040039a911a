//! Runs one task per critic, on the caller's thread or spread over several.

use copq::Result;

use super::threads::Threads;
use super::workspace::Workspace;

/// The threads that share the critics. Each critic is computed by one thread, so the number of
/// threads changes no bit.
#[derive(Debug)]
pub(super) struct Workers {
    threads: Threads,
    /// One per thread.
    workspaces: Vec<Workspace>,
}

impl Workers {
    /// `threads` threads; one means the caller's own.
    pub fn new(threads: usize) -> Result<Self> {
        Ok(Self {
            threads: Threads::new(threads)?,
            workspaces: vec![Workspace::default(); threads],
        })
    }

    /// Runs `task` on each item, given its index and its equal share of `chunks`. A thread takes a
    /// group of neighbouring items.
    pub fn each<T: Send>(
        &mut self,
        items: &mut [T],
        chunks: &mut [f32],
        task: impl Fn(usize, &mut T, &mut [f32], &mut Workspace) + Sync,
    ) {
        let count = items.len();
        let size = count.div_ceil(self.threads.count());
        let share = chunks.len() / count;
        let parts = items
            .chunks_mut(size)
            .zip(chunks.chunks_mut(size * share))
            .zip(&mut self.workspaces)
            .enumerate();
        self.threads.each(parts, |(i, ((items, chunks), workspace))| {
            for (k, (item, chunk)) in
                (i * size..).zip(items.iter_mut().zip(chunks.chunks_exact_mut(share)))
            {
                task(k, item, chunk, workspace);
            }
        });
    }
}
