//! The tasks by name.

use copq::{Error, Result};

use super::{Task, benchmark_a};

const NAMES: [&str; 1] = ["a/hopper"];

/// The names that [`task`] knows.
pub fn tasks() -> &'static [&'static str] {
    &NAMES
}

/// The task of this name; an unknown one is answered with the nearest names.
pub fn task(name: &str) -> Result<Task> {
    match name {
        "a/hopper" => Ok(benchmark_a::hopper()),
        _ => Err(Error::unknown("task", name, &NAMES)),
    }
}
