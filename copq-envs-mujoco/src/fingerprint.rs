//! What tells models apart whose robots have the same name.

use copq::{Error, Result, State};

/// A model, by the FNV-1a hash of its MJCF, which is the same everywhere and always.
#[derive(Debug)]
pub(crate) struct Fingerprint(u64);

impl Fingerprint {
    pub fn new(mjcf: &str) -> Self {
        Self(mjcf.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        }))
    }

    pub fn save(&self, state: &mut State) {
        state.put("model", [self.0]);
    }

    /// An error unless a state was saved from this model of `robot`.
    pub fn check(&self, state: &State, robot: &str) -> Result<()> {
        if state.get_one::<u64>("model")? == self.0 {
            return Ok(());
        }
        let what = "model of a saved state";
        Err(Error::invalid(what, format!("this {robot}"), "another preset's"))
    }
}
