//! `copq doctor`: which engines this build has, whether they work, and what Python has.

use std::env;
use std::ffi::OsStr;
use std::path::PathBuf;

use copq_envs_mujoco::doctor;
use copq_envs_python::{PACKAGES, interpreter, look};

use crate::options::say;

/// Checks the MuJoCo of this build and the environments of your Python.
///
/// Reports which MuJoCo this build has, whether it fits, which environments your Python has, and
/// the one thing to do next. Fails if there is something to do.
#[derive(clap::Args)]
pub struct Doctor {
    /// Interpreter to check, such as .venv/bin/python. [default: what COPQ_PYTHON names, or
    /// python3]
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
}

impl Doctor {
    pub fn run(self) -> anyhow::Result<()> {
        let report = doctor();
        let mut lines = vec!["engine rapier: built in".to_owned()];
        lines.extend(report.lines);
        let python = self.python_lines();
        let has_python = python.is_ok();
        lines.extend(python.unwrap_or_else(|line| vec![line]));
        let built = cfg!(any(feature = "mujoco", feature = "system"));
        let next = report.next.filter(|_| built);
        let named = self.named_python().filter(|_| !has_python);
        match (&next, built) {
            (None, _) if named.is_some() => {}
            (None, true) => lines.push("next: nothing, it works".to_owned()),
            (None, false) => lines.push(
                "next: nothing, rapier works; for MuJoCo run scripts/fetch-mujoco.sh, then build \
                 copq with --features mujoco"
                    .to_owned(),
            ),
            (Some(_), _) => {}
        }
        say(&(lines.join("\n") + "\n"))?;
        match (next, named) {
            (Some(next), _) => anyhow::bail!("next: {next}"),
            (None, Some(named)) => {
                anyhow::bail!("next: {named}: wanted an interpreter that starts")
            }
            (None, None) => Ok(()),
        }
    }

    /// What names an interpreter, the option or the variable, and which one.
    fn named_python(&self) -> Option<String> {
        let named = |who: &str, path: &OsStr| format!("{who} {}", path.display());
        let variable = || env::var_os("COPQ_PYTHON").map(|path| named("COPQ_PYTHON", &path));
        self.python.as_ref().map(|path| named("--python", path.as_os_str())).or_else(variable)
    }

    /// What the interpreter has, and what it could have; or, for one that does not start, a line
    /// that says so.
    fn python_lines(&self) -> Result<Vec<String>, String> {
        let found = look(&interpreter(self.python.as_deref()));
        let python = found.python.display();
        let version = match found.version {
            Ok(version) => version,
            Err(error) => return Err(format!("python {python}: {error}; no environments from it")),
        };
        let mut lines = vec![format!("python {python}: {version}")];
        for (name, version) in found.packages {
            lines.push(match version {
                Some(version) => format!("python {name}: {version}"),
                None if PACKAGES.contains(&name.as_str()) => {
                    format!("python {name}: none (pip install {name})")
                }
                None => continue,
            });
        }
        Ok(lines)
    }
}
