//! The processor's cores: how many runs fit, and a place for each.

use std::collections::BTreeSet;

/// One processor of every core that this process may use, by the system's numbers; empty where the
/// system does not say.
pub fn cores() -> Vec<usize> {
    let mut seen = BTreeSet::new();
    allowed().into_iter().filter(|&cpu| seen.insert(core_of(cpu))).collect()
}

/// The processors that share a core with this one, as Linux lists them.
fn core_of(cpu: usize) -> String {
    let file = format!("/sys/devices/system/cpu/cpu{cpu}/topology/thread_siblings_list");
    std::fs::read_to_string(file).unwrap_or_else(|_| cpu.to_string())
}

#[cfg(target_os = "linux")]
fn allowed() -> Vec<usize> {
    use rustix::thread::{CpuSet, sched_getaffinity};
    let set = sched_getaffinity(None).unwrap_or_else(|_| CpuSet::new());
    (0..CpuSet::MAX_CPU).filter(|&cpu| set.is_set(cpu)).collect()
}

#[cfg(not(target_os = "linux"))]
fn allowed() -> Vec<usize> {
    Vec::new()
}

/// Keeps this process and its future threads on one processor, where the system allows it.
#[cfg(target_os = "linux")]
pub fn stay_on(cpu: usize) {
    use rustix::thread::{CpuSet, sched_setaffinity};
    if cpu < CpuSet::MAX_CPU {
        let mut set = CpuSet::new();
        set.set(cpu);
        sched_setaffinity(None, &set).unwrap_or_default();
    }
}

/// Names this process for lists of processes: the name that it was started by may say nothing.
#[cfg(target_os = "linux")]
pub fn be_called_copq() {
    rustix::thread::set_name(c"copq").unwrap_or_default();
}

/// Names this process: not on this system.
#[cfg(not(target_os = "linux"))]
pub fn be_called_copq() {}

/// Keeps this process on one processor: not on this system.
#[cfg(not(target_os = "linux"))]
pub fn stay_on(_: usize) {}

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    #[test]
    fn a_thread_stays_on_its_core() {
        let cores = super::cores();
        assert!(!cores.is_empty());
        std::thread::spawn(move || {
            super::stay_on(cores[0]);
            assert_eq!(super::cores(), cores[..1]);
        })
        .join()
        .unwrap();
    }
}
