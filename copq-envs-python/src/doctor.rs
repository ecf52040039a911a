//! What an interpreter has.

use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

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

/// How long an interpreter may take to answer.
const PATIENCE: Duration = Duration::from_secs(20);

/// An interpreter and its packages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The interpreter.
    pub python: PathBuf,
    /// Its version, or why there is none.
    pub version: Result<String, String>,
    /// The packages that environments come from or need, each with its version if it is installed.
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
    let (said, complaint) = match ask(python) {
        Err(error) => return found(Err(error.to_string()), Vec::new()),
        Ok(said) => said,
    };
    // A script around the interpreter may print something before it starts.
    let mut lines = said.lines().skip_while(|line| !line.starts_with("Python "));
    let version = match lines.next() {
        Some(version) => version.to_owned(),
        None => {
            let last = complaint.lines().last().unwrap_or("not a Python interpreter").to_owned();
            return found(Err(last), Vec::new());
        }
    };
    let packages = lines.map(|line| match line.split_once(' ') {
        Some((name, version)) => (name.to_owned(), Some(version.to_owned())),
        None => (line.to_owned(), None),
    });
    found(Ok(version), packages.collect())
}

/// What an interpreter writes to standard output and standard error; it is short, and fits the
/// system's buffer.
fn ask(python: &Path) -> io::Result<(String, String)> {
    let mut command = Command::new(python);
    command.args(["-c", PROGRAM]).stdin(Stdio::null());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let began = Instant::now();
    while child.try_wait()?.is_none() {
        if began.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            return Err(io::ErrorKind::TimedOut.into());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut said = Vec::new();
    let mut complaint = Vec::new();
    if let (Some(mut output), Some(mut errors)) = (child.stdout, child.stderr) {
        output.read_to_end(&mut said)?;
        errors.read_to_end(&mut complaint)?;
    }
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ok((text(&said), text(&complaint)))
}
