//! The tasks by name.

use copq::{Error, Result};

use super::nearest::nearest;
use super::{Task, benchmark_a};

const NAMES: [&str; 1] = ["a/hopper"];
const MAKERS: [fn() -> Task; 1] = [benchmark_a::hopper];

/// The names that [`task`] knows.
pub fn tasks() -> &'static [&'static str] {
    &NAMES
}

/// The task of this name; an unknown one is answered with the nearest names.
pub fn task(name: &str) -> Result<Task> {
    match NAMES.iter().position(|known| *known == name) {
        Some(index) => Ok(MAKERS[index]()),
        None => Err(Error::Unknown { kind: "task", name: name.into(), known: nearest(name, &NAMES).join(", ") }),
    }
}
