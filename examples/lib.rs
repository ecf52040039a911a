//! What the examples share: how long they train.

use copq::{Error, Result};

/// The number of steps given on the command line, its only argument.
pub fn steps(default: u64) -> Result<u64> {
    let Some(given) = std::env::args().nth(1) else { return Ok(default) };
    let wanted = format!("steps to train for, such as {default}");
    given.parse().map_err(|_| Error::invalid("the argument", wanted, given))
}
