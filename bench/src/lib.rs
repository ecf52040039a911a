//! What benchmarks share: clocks, medians, episodes, and one update of COP-TD3 in several programs.

#![allow(missing_debug_implementations)] // Programs, not values to print.

pub mod coarse;
pub mod rounds;
pub mod update;
pub mod workload;

use copq::{Env, Outcome, Result, Rng};
use rustix::time::{ClockId, clock_gettime};

/// All robots, by the names of their tasks.
pub const ROBOTS: [&str; 5] = ["hopper", "walker2d", "halfcheetah", "ant", "humanoid"];

/// CPU time of this thread so far (ns); it excludes whatever else runs on the machine.
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

/// A [`spread`] as a cell of a table.
pub fn text([low, median, high]: [f64; 3]) -> String {
    format!("{median:.2} ({low:.2}-{high:.2})")
}

/// Nanoseconds per step over episodes of random actions. Resets are not timed.
pub fn episodes(env: &mut dyn Env, steps: usize, seed: u64) -> Result<f64> {
    let mut obs = vec![0.0; env.spec().obs_len];
    let mut reward = vec![0.0; env.spec().objectives.len()];
    let mut rng = Rng::with_stream(seed, 2);
    let action =
        |_| (0..env.spec().action_len()).map(|_| rng.uniform_in(-1.0, 1.0) as f32).collect();
    let actions: Vec<Vec<f32>> = (0..steps).map(action).collect();
    let mut actions = actions.iter().peekable();
    let mut time = 0.0;
    while actions.peek().is_some() {
        env.reset(rng.next_u64(), &mut obs)?;
        let start = cpu_time();
        for action in actions.by_ref() {
            if env.step(action, &mut obs, &mut reward)? != Outcome::Running {
                break;
            }
        }
        time += cpu_time() - start;
    }
    Ok(time / steps as f64)
}
