//! Finding and opening the installed library, once per process.

use std::env;
use std::ffi::CString;
use std::ptr;
use std::sync::OnceLock;

use copq::{Error, Result};

use super::shim::{Shim, copq_mujoco};
use crate::c_text::words;
use crate::version::{check_version, dotted};

/// The variable that names the library's file at run time.
const FILE: &str = "COPQ_MUJOCO_LIBRARY";
const INSTALL: &str =
    "install MuJoCo's library and headers (Debian: apt-get install libmujoco-dev)";

/// The shim with its library open. The first call opens it; every later call gives the same answer.
pub(super) fn library() -> Result<&'static Shim> {
    static LIBRARY: OnceLock<std::result::Result<&'static Shim, String>> = OnceLock::new();
    let opened = LIBRARY.get_or_init(open).clone();
    opened.map_err(|what| Error::Env { env: "system MuJoCo".into(), what })
}

/// The version of the headers at build time, as `mj_version` counts, if there were any.
pub(super) fn header() -> Option<i32> {
    shim().map(|shim| shim.header)
}

fn shim() -> Option<&'static Shim> {
    // SAFETY: null, or a constant of shim.c laid out as Shim.
    unsafe { copq_mujoco().as_ref() }
}

fn open() -> std::result::Result<&'static Shim, String> {
    let Some(shim) = shim() else {
        let what = "this program was built without MuJoCo's headers";
        return Err(format!("{what}; {INSTALL}, or set COPQ_MUJOCO_DIR, and build again"));
    };
    let mut failures = Vec::new();
    for file in candidates(shim.header) {
        match try_open(shim, &file) {
            Ok(version) => {
                check_version(shim.header, version, &file).map_err(|error| error.to_string())?;
                return Ok(shim);
            }
            Err(failure) => failures.push(failure),
        }
    }
    let version = dotted(shim.header);
    let failures = failures.join("; ");
    Err(format!("MuJoCo {version} was not found ({failures}); {INSTALL}, or set {FILE}"))
}

/// The files to try: the one that the variable names, or else the one found with the headers and
/// those that the loader knows.
fn candidates(header: i32) -> Vec<String> {
    if let Ok(file) = env::var(FILE) {
        return vec![file];
    }
    let version = dotted(header);
    let names = if cfg!(target_os = "macos") {
        [format!("libmujoco.{version}.dylib"), "libmujoco.dylib".into()]
    } else {
        [format!("libmujoco.so.{version}"), "libmujoco.so".into()]
    };
    option_env!("COPQ_MUJOCO_FOUND").map(String::from).into_iter().chain(names).collect()
}

fn try_open(shim: &Shim, file: &str) -> std::result::Result<i32, String> {
    let path = CString::new(file).map_err(|error| error.to_string())?;
    let mut version = 0;
    // SAFETY: a string and a number that outlive the call; opening a library runs its constructors,
    // and MuJoCo's are harmless.
    let failure = unsafe { (shim.open)(path.as_ptr(), ptr::from_mut(&mut version)) };
    // SAFETY: null, or the loader's message, which lasts until it is called again.
    if failure.is_null() { Ok(version) } else { Err(unsafe { words(failure) }) }
}
