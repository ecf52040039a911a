//! What an interpreter has.

use std::path::{Path, PathBuf};
use std::process::Command;

const PROGRAM: &str = "\
import sys
from importlib import metadata
print('Python ' + sys.version.split()[0])
for name in ['gymnasium', 'mo-gymnasium', 'safety-gymnasium', 'mujoco', 'numpy']:
    try:
        print(name, metadata.version(name))
    except metadata.PackageNotFoundError:
        print(name)
";

/// An interpreter and its packages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The interpreter.
    pub python: PathBuf,
    /// Its version, or why there is none.
    pub version: Result<String, String>,
    /// The packages that environments come from or need, each with its version if it is there.
    pub packages: Vec<(String, Option<String>)>,
}

/// Asks an interpreter ([`interpreter`](crate::interpreter)) what it has.
///
/// ```
/// let found = copq_envs_python::look(std::path::Path::new("/no/such/python"));
/// assert!(found.version.is_err() && found.packages.is_empty());
/// ```
pub fn look(python: &Path) -> Found {
    let found = |version, packages| Found { python: python.to_owned(), version, packages };
    let output = match Command::new(python).args(["-c", PROGRAM]).output() {
        Err(error) => return found(Err(error.to_string()), Vec::new()),
        Ok(output) if !output.status.success() => {
            let said = String::from_utf8_lossy(&output.stderr);
            let last = said.lines().last().unwrap_or("no word").to_owned();
            return found(Err(last), Vec::new());
        }
        Ok(output) => output,
    };
    let text = String::from_utf8_lossy(&output.stdout);
    let mut lines = text.lines();
    let version = lines.next().unwrap_or_default().to_owned();
    let packages = lines.map(|line| match line.split_once(' ') {
        Some((name, version)) => (name.to_owned(), Some(version.to_owned())),
        None => (line.to_owned(), None),
    });
    found(Ok(version), packages.collect())
}
