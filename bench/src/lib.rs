//! What benchmarks share: a clock of this thread's CPU time, medians.

use rustix::time::{ClockId, clock_gettime};

/// CPU time of this thread so far (ns); what others do on the machine is not in it.
pub fn cpu_time() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e9 + now.tv_nsec as f64
}

/// Smallest, median and largest of some numbers (at least one).
pub fn spread(values: &mut [f64]) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [values[0], values[values.len() / 2], values[values.len() - 1]]
}
