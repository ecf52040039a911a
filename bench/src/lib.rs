//! What benchmarks share: clocks, medians, and one update of TD3-COP in several programs.

#![allow(missing_debug_implementations)] // Programs, not values to print.

pub mod rounds;
pub mod update;
pub mod workload;

use rustix::time::{ClockId, clock_gettime};

/// CPU time of this thread so far (ns); what others do on the machine is not in it.
pub fn cpu_time() -> f64 {
    clock(ClockId::ThreadCPUTime)
}

/// CPU time of all threads of this process so far (ns).
pub fn process_time() -> f64 {
    clock(ClockId::ProcessCPUTime)
}

fn clock(clock: ClockId) -> f64 {
    let now = clock_gettime(clock);
    now.tv_sec as f64 * 1e9 + now.tv_nsec as f64
}

/// Smallest, median and largest of some numbers (at least one).
pub fn spread(values: &mut [f64]) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [values[0], values[values.len() / 2], values[values.len() - 1]]
}
