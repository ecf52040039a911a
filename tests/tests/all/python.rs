//! A Python with the libraries that read what copq leaves, for the tests that want one.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const PACKAGES: &str = "import numpy, onnx, onnxruntime, pandas, safetensors";

/// The repository.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// The interpreter that `COPQ_TEST_PYTHON` names, or the one in third_party. A test without one
/// says so where nothing captures it, and is skipped.
pub fn python(test: &str) -> Option<PathBuf> {
    let usual = workspace().join("third_party/gymnasium/bin/python");
    let python = match std::env::var_os("COPQ_TEST_PYTHON") {
        Some(named) => PathBuf::from(named),
        None if usual.exists() => usual,
        None => {
            skipped(test, "no Python: COPQ_TEST_PYTHON, or scripts/python-worlds.sh");
            return None;
        }
    };
    let has_packages = Command::new(&python).args(["-c", PACKAGES]).output();
    if has_packages.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    skipped(test, &format!("{} cannot {PACKAGES}", python.display()));
    None
}

fn skipped(test: &str, why: &str) {
    writeln!(std::io::stderr(), "\n!! SKIPPED: {test}, for there is {why}").unwrap_or_default();
}

/// Runs a script with one argument; what it prints.
pub fn run(python: &Path, script: &Path, argument: &Path) -> String {
    let output = Command::new(python).arg(script).arg(argument).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{}: {said}", script.display());
    String::from_utf8(output.stdout).unwrap()
}
