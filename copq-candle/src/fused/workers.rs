//! Running one task a critic, on the caller's thread or spread over several.

use std::ops::Deref;

use copq::Result;

use super::threads::Threads;
use super::workspace::Workspace;

/// The threads that share the critics; each critic's numbers come from one thread, so their count
/// changes no bit.
#[derive(Debug)]
pub(super) struct Workers {
    threads: Threads,
    /// One per thread.
    workspaces: Vec<Workspace>,
}

impl Workers {
    /// `threads` of them; one means the caller's own.
    pub fn new(threads: usize) -> Result<Self> {
        Ok(Self {
            threads: Threads::new(threads)?,
            workspaces: vec![Workspace::default(); threads],
        })
    }

    /// Runs `task` on each critic, given its number and its equal share of `chunks`. `groups` is
    /// what cuts a slice into groups of a size; a thread takes one.
    pub fn each<T, S: Deref<Target = [T]>, I: Iterator<Item: IntoIterator + Send>>(
        &mut self,
        critics: S,
        groups: impl FnOnce(S, usize) -> I,
        chunks: &mut [f32],
        task: impl Fn(usize, <I::Item as IntoIterator>::Item, &mut [f32], &mut Workspace) + Sync,
    ) {
        let count = critics.len();
        let size = count.div_ceil(self.threads.count());
        let share = chunks.len() / count;
        let parts = groups(critics, size)
            .zip(chunks.chunks_mut(size * share))
            .zip(&mut self.workspaces)
            .enumerate();
        self.threads.each(parts, |(i, ((group, chunks), workspace))| {
            for (k, (critic, chunk)) in
                (i * size..).zip(group.into_iter().zip(chunks.chunks_exact_mut(share)))
            {
                task(k, critic, chunk, workspace);
            }
        });
    }
}
