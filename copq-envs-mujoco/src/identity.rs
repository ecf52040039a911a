//! What a saved state must agree with to be loaded.

use copq::{Error, Result, State};
use copq_envs::RobotSpec;

/// An engine with a model.
#[derive(Debug)]
pub(crate) struct Identity {
    /// The engine's name and version.
    pub engine: String,
    /// The robot's name.
    pub robot: String,
    /// Tells models apart whose robots have the same name.
    fingerprint: u64,
}

impl Identity {
    pub fn new(engine: String, robot: &RobotSpec, mjcf: &str) -> Self {
        Self { engine, robot: robot.name.clone(), fingerprint: fingerprint(mjcf.as_bytes()) }
    }

    pub fn save(&self, state: &mut State) {
        state.put("engine", self.engine.as_bytes());
        state.put("robot", self.robot.as_bytes());
        state.put("model", [self.fingerprint]);
    }

    /// An error that names what is different.
    pub fn check(&self, state: &State) -> Result<()> {
        for (key, wanted) in [("engine", &self.engine), ("robot", &self.robot)] {
            let got = state.get::<u8>(key)?;
            if got != wanted.as_bytes() {
                return Err(Error::invalid(
                    format!("{key} of a saved state"),
                    wanted,
                    String::from_utf8_lossy(got),
                ));
            }
        }
        if state.get_one::<u64>("model")? != self.fingerprint {
            return Err(Error::invalid(
                "model of a saved state",
                format!("this {}", self.robot),
                "another preset's",
            ));
        }
        Ok(())
    }
}

/// The FNV-1a hash, which is the same everywhere and always.
fn fingerprint(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
