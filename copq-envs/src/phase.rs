//! Where an episode stands.

use copq::{Error, Result};

/// Whether there is an episode to step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub(crate) enum Phase {
    Fresh = 0,
    Running = 1,
    Over = 2,
}

impl Phase {
    /// The inverse of `self as u64`.
    pub(crate) fn from_number(number: u64) -> Result<Self> {
        match number {
            0 => Ok(Self::Fresh),
            1 => Ok(Self::Running),
            2 => Ok(Self::Over),
            other => Err(Error::invalid("saved phase of an episode", "0, 1 or 2", other)),
        }
    }
}
