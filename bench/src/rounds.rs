//! Interleaved rounds: programs that ran side by side are compared round by round, so that the
//! machine's drift cancels out.

use std::time::Instant;

use anyhow::Result;

use crate::update::Update;
use crate::workload::{Inputs, Workload};
use crate::{process_time, spread};

/// Time of an update (ms): wall time, and CPU time of all the process's threads.
#[derive(Clone, Copy, Debug)]
pub struct Time {
    /// How long a user waits.
    pub wall: f64,
    /// How long the processors worked.
    pub cpu: f64,
}

/// A program in the middle of its updates.
pub struct Running {
    update: Box<dyn Update>,
    batches: Vec<Inputs>,
    done: usize,
}

impl Running {
    /// One that has not begun.
    pub fn new(update: Box<dyn Update>, workload: &Workload) -> Self {
        Self { update, batches: workload.batches(), done: 0 }
    }

    /// Does `updates` more updates.
    pub fn run(&mut self, updates: usize) -> Result<()> {
        for _ in 0..updates {
            let batch = &self.batches[self.done % self.batches.len()];
            self.done += 1;
            self.update.update(self.done, batch)?;
        }
        Ok(())
    }

    /// Does `updates` more updates; returns the mean time of one.
    pub fn time(&mut self, updates: usize) -> Result<Time> {
        let start = Instant::now();
        let cpu = process_time();
        self.run(updates)?;
        let scale = 1e-6 / updates as f64;
        Ok(Time {
            wall: start.elapsed().as_nanos() as f64 * scale,
            cpu: (process_time() - cpu) * scale,
        })
    }
}

/// Every program's times in each of `rounds` rounds, after one warm-up round.
pub fn interleave(
    running: &mut [Running],
    rounds: usize,
    updates: usize,
) -> Result<Vec<Vec<Time>>> {
    let mut times = vec![Vec::new(); running.len()];
    for round in 0..=rounds {
        for (times, running) in times.iter_mut().zip(running.iter_mut()) {
            let time = running.time(updates)?;
            if round > 0 {
                times.push(time);
            }
        }
    }
    Ok(times)
}

/// `median (smallest-largest)` of some times.
pub fn text(times: &[Time], part: fn(&Time) -> f64) -> String {
    format(times.iter().map(part))
}

/// `median (smallest-largest)` of the ratios of neighbouring rounds.
pub fn ratio(times: &[Time], to: &[Time], part: fn(&Time) -> f64) -> String {
    format(times.iter().zip(to).map(|(a, b)| part(a) / part(b)))
}

fn format(values: impl Iterator<Item = f64>) -> String {
    crate::text(spread(&mut values.collect::<Vec<_>>()))
}
