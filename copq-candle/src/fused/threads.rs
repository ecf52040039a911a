//! Threads that share a task's parts.

use std::sync::Arc;

use copq::{Error, Result};
use rayon::ThreadPool;

use copq::error::check_count;

/// Multiplications below which a product takes less time than waking a thread.
const WORTH_SHARING: usize = 1 << 21;

/// The caller's thread, and any others that help it.
#[derive(Clone, Debug, Default)]
pub(super) struct Threads {
    helpers: Option<Arc<ThreadPool>>,
}

impl Threads {
    /// `count` threads; one means the caller's own.
    pub fn new(count: usize) -> Result<Self> {
        check_count("threads", count)?;
        let start = || rayon::ThreadPoolBuilder::new().num_threads(count - 1).build().map(Arc::new);
        let helpers =
            (count > 1).then(start).transpose().map_err(|e| Error::other("starting threads", e))?;
        Ok(Self { helpers })
    }

    /// Number of threads, including the caller's.
    pub fn count(&self) -> usize {
        self.helpers.as_ref().map_or(1, |helpers| helpers.current_num_threads() + 1)
    }

    /// How many of a product's panels a thread takes, given the product's number of
    /// multiplications.
    pub fn share(&self, panels: usize, multiplications: usize) -> usize {
        if multiplications < WORTH_SHARING { panels } else { panels.div_ceil(self.count()) }
    }

    /// Runs `task` on every part, the first on the caller's own thread.
    pub fn each<T: Send>(&self, mut parts: impl Iterator<Item = T>, task: impl Fn(T) + Sync) {
        match &self.helpers {
            None => parts.for_each(task),
            Some(helpers) => helpers.in_place_scope(|scope| {
                let own = parts.next();
                let task = &task;
                parts.for_each(|part| scope.spawn(move |_| task(part)));
                own.into_iter().for_each(task);
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_done_once_on_any_number_of_threads() {
        for count in 1..5 {
            for parts in 0..9 {
                let mut done = vec![0; parts];
                let threads = Threads::new(count).unwrap();
                threads.each(done.iter_mut().enumerate(), |(i, done)| *done += i + 1);
                assert_eq!(done, (1..=parts).collect::<Vec<_>>(), "{count} threads");
                assert_eq!(threads.count(), count);
            }
        }
    }
}
