//! Python environments for copq: any from Gymnasium, MO-Gymnasium or Safety-Gymnasium, and those
//! that you have registered yourself. Observations and actions must be boxes of numbers (actions:
//! floats within finite bounds), and episodes must have a step limit.
//!
//! Python's own random generator, NumPy's and those of the spaces are seeded at every reset; others
//! are not. `PYTHONHASHSEED` is 0 unless it is set. What an environment prints goes to standard
//! error.
//!
//! Each runs in its own process, with the interpreter that you name. Python is not needed to build
//! or install copq, and an environment that crashes is an error, not a crash.
//!
//! ```no_run
//! use copq::Outcome;
//!
//! let mut env = copq_envs_python::make("mo-gymnasium:mo-hopper-v5")?;
//! let mut obs = vec![0.0; env.spec().obs_len];
//! let mut reward = vec![0.0; env.spec().objectives.len()];
//! env.reset(1, &mut obs)?;
//! let outcome = env.step(&[0.1, -0.2, 0.3], &mut obs, &mut reward)?;
//! assert_eq!(outcome, Outcome::Running);
//! assert_eq!(env.spec().names(), ["reward.0", "reward.1", "reward.2"]);
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! Names are `PACKAGE:ID`: `gymnasium:Pendulum-v1`, `mo-gymnasium:mo-hopper-v5`,
//! `safety-gymnasium:SafetyHopperVelocity-v1`, or `gymnasium:my_module:MyEnv-v0`, which imports
//! `my_module` first.
//!
//! This works only on Unix, because it uses a Unix socket; elsewhere, making one is an error.

mod doctor;
mod env;
#[cfg(unix)]
mod errors;
mod hello;
mod options;
#[cfg(unix)]
mod worker;
#[cfg(not(unix))]
#[path = "no_worker.rs"]
mod worker;

pub use doctor::{Found, look};
pub use env::{PACKAGES, Picture, PythonEnv};
pub use options::Options;

use std::path::{Path, PathBuf};

use copq::{Env, Result};

/// The environment of this name, with the interpreter that `COPQ_PYTHON` names, or else `python3`.
pub fn make(task: &str) -> Result<Box<dyn Env>> {
    make_with(task, &Options::default())
}

/// The environment of this name with these options.
pub fn make_with(task: &str, options: &Options) -> Result<Box<dyn Env>> {
    Ok(Box::new(PythonEnv::new(task, options)?))
}

/// Whether this is the name of a Python environment.
///
/// ```
/// assert!(copq_envs_python::is_task("gymnasium:Pendulum-v1"));
/// assert!(!copq_envs_python::is_task("gym/hopper"));
/// ```
pub fn is_task(name: &str) -> bool {
    env::parts(name).is_some()
}

/// The interpreter to use: the one given, or the one that the variable `COPQ_PYTHON` names, or else
/// `python3`.
pub fn interpreter(given: Option<&Path>) -> PathBuf {
    let named = || std::env::var_os("COPQ_PYTHON").map(PathBuf::from);
    given.map(Path::to_owned).or_else(named).unwrap_or_else(|| "python3".into())
}
