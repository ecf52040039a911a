//! Which engine simulates which robot: the names in its errors, the inputs it accepts, and what a
//! saved state must match.

use copq::error::check_len;
use copq::{Error, Result, State};

use crate::{Dims, RobotSpec};

/// The identity of an engine with a model, for implementers of [`Physics`](crate::Physics).
///
/// ```
/// use copq::State;
/// use copq_envs::Identity;
///
/// let identity = Identity::new("springs 1.0", &copq_envs::task("a/hopper")?.robot);
/// assert!(identity.check_ctrl(&[0.5; 3]).is_ok());
/// let error = identity.check_ctrl(&[0.5, f64::NAN, 0.0]).unwrap_err().to_string();
/// assert!(error.contains("'hopper on springs 1.0': a control is not finite"), "{error}");
///
/// let mut state = State::default();
/// identity.save(&mut state);
/// let other = Identity::new("springs 2.0", &copq_envs::task("a/hopper")?.robot);
/// let error = other.check(&state).unwrap_err().to_string();
/// assert_eq!(error, "engine of a saved state: wanted springs 2.0, got springs 1.0");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Identity {
    engine: String,
    robot: String,
    dims: Dims,
    /// A hash of the description. It tells apart robots of the same name, such as those of two
    /// presets.
    model: u64,
}

/// The version of MuJoCo that the hashed description is written for, whatever the engine.
const VERSION: i32 = 3_017_000;

/// The FNV-1a hash, which is always the same, on every machine.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

impl Identity {
    /// The identity of this robot on the engine with this name and version.
    pub fn new(engine: impl Into<String>, robot: &RobotSpec) -> Self {
        let model = hash(&robot.mjcf(VERSION));
        Self { engine: engine.into(), robot: robot.name.clone(), dims: robot.dims(), model }
    }

    /// The engine's name and version.
    pub fn engine(&self) -> &str {
        &self.engine
    }

    /// The sizes of the model.
    pub fn dims(&self) -> Dims {
        self.dims
    }

    /// An error about this robot on this engine.
    pub fn error(&self, what: impl Into<String>) -> Error {
        Error::Env { env: format!("{} on {}", self.robot, self.engine), what: what.into() }
    }

    /// An error unless a position and a velocity have the model's lengths and are finite.
    pub fn check_state(&self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
        check_len("qpos", qpos.len(), self.dims.nq)?;
        check_len("qvel", qvel.len(), self.dims.nv)?;
        if qpos.iter().chain(qvel).all(|value| value.is_finite()) {
            return Ok(());
        }
        Err(self.error(format!("reset to a state that is not finite: {qpos:?}, {qvel:?}")))
    }

    /// An error unless there is one finite control for each actuator.
    pub fn check_ctrl(&self, ctrl: &[f64]) -> Result<()> {
        check_len("ctrl", ctrl.len(), self.dims.nu)?;
        if ctrl.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        Err(self.error(format!("a control is not finite: {ctrl:?}")))
    }

    /// Writes what [`Identity::check`] compares.
    pub fn save(&self, state: &mut State) {
        state.put("engine", self.engine.as_bytes());
        state.put("robot", self.robot.as_bytes());
        state.put("description", [self.model]);
    }

    /// An error that names the difference, if the state was saved by a different engine, for a
    /// different robot, or for a robot of the same name with different numbers.
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
        // Older states have no description.
        match state.get_one::<u64>("description") {
            Ok(saved) if saved != self.model => {
                let wanted = format!("this {}", self.robot);
                let got = "one with different numbers, such as another preset's";
                Err(Error::invalid("robot of a saved state", wanted, got))
            }
            _ => Ok(()),
        }
    }
}
