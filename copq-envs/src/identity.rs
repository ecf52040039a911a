//! Which engine has which robot: what its errors name, what it takes, and what a saved state must
//! agree with.

use copq::error::check_len;
use copq::{Error, Result, State};

use crate::{Dims, RobotSpec};

/// An engine with a model, for those who implement [`Physics`](crate::Physics).
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
    /// What tells robots of one name apart, such as two presets': a hash of the description.
    model: u64,
}

/// The version of MuJoCo for which a description is told, whatever the engine.
const VERSION: i32 = 3_017_000;

/// The FNV-1a hash, which is the same everywhere and always.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

impl Identity {
    /// Given the engine's name and version.
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

    /// An error of this robot on this engine.
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

    /// Writes what [`Identity::check`] looks at.
    pub fn save(&self, state: &mut State) {
        state.put("engine", self.engine.as_bytes());
        state.put("robot", self.robot.as_bytes());
        state.put("description", [self.model]);
    }

    /// An error that names what is different, if a state was saved by another engine, of another
    /// robot, or of one of this name with other numbers.
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
        // States from before there was one say nothing.
        match state.get_one::<u64>("description") {
            Ok(saved) if saved != self.model => {
                let wanted = format!("this {}", self.robot);
                let got = "one with other numbers, such as another preset's";
                Err(Error::invalid("robot of a saved state", wanted, got))
            }
            _ => Ok(()),
        }
    }
}
