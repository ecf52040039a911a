//! Interpreters to test with.

use std::io::Write;
use std::path::PathBuf;

use copq_envs_python::{Options, PythonEnv};

/// The interpreter with the packages that a task needs; none, and a word about it, if it is not
/// there.
pub fn python(task: &str) -> Option<PathBuf> {
    let (variable, folder) = match task.starts_with("safety-") {
        true => ("COPQ_TEST_SAFETY_PYTHON", "safety-gymnasium"),
        false => ("COPQ_TEST_PYTHON", "gymnasium"),
    };
    let ours = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../third_party")
        .join(folder)
        .join("bin/python");
    let python = std::env::var_os(variable).map_or(ours, PathBuf::from);
    if !python.exists() {
        writeln!(
            std::io::stderr(),
            "SKIPPED: {task}, for there is no {} (scripts/python-worlds.sh)",
            python.display()
        )
        .unwrap_or_default();
        return None;
    }
    Some(python)
}

/// An environment that misbehaves.
pub fn faulty(fault: &str) -> Option<copq::Result<PythonEnv>> {
    made("gymnasium:copq/Faulty-v0", fault)
}

/// One that takes too long to start.
pub fn slow() -> Option<copq::Result<PythonEnv>> {
    waited_for("gymnasium:copq/Faulty-v0", "slow start", 1.0)
}

pub fn made(task: &str, fault: &str) -> Option<copq::Result<PythonEnv>> {
    waited_for(task, fault, 5.0)
}

fn waited_for(task: &str, fault: &str, timeout: f64) -> Option<copq::Result<PythonEnv>> {
    let options = Options {
        python: Some(python(task)?),
        kwargs: format!(r#"{{"fault": "{fault}"}}"#),
        imports: vec![format!("{}/copq_faulty.py", data())],
        timeout,
        ..Options::default()
    };
    Some(PythonEnv::new(task, &options))
}

/// The folder of the tests' own modules.
pub fn data() -> &'static str {
    concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")
}
