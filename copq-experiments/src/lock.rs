//! One process at a time writes to a run's folder.

use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::Path;
use std::sync::OnceLock;
use std::thread::sleep;
use std::time::Duration;

use copq::{Error, Result, files};
use gethostname::gethostname;

/// Held open and locked by the process that writes.
pub(crate) const LOCK: &str = ".lock";
/// A process that only looks holds a lock for a moment: how often, and how long, to wait for it.
const LOOKS: usize = 10;
const LOOK: Duration = Duration::from_millis(20);

/// Locks a folder for this process. The error for one that is locked says by whom.
pub(crate) fn lock(path: &Path) -> Result<File> {
    let file = path.join(LOCK);
    // Never emptied by a process that does not hold it: it says which one does.
    let opened = File::options().create(true).truncate(false).write(true).open(&file);
    let mut lock = opened.map_err(files::failed("making", &file))?;
    let mut locked = lock.try_lock();
    for _ in 0..LOOKS {
        if !matches!(locked, Err(TryLockError::WouldBlock)) {
            break;
        }
        sleep(LOOK);
        locked = lock.try_lock();
    }
    // Some network drives do not support locks; then the user has to take care.
    if matches!(locked, Err(TryLockError::WouldBlock)) {
        let what = format!("run folder '{}'", path.display());
        let got = format!("one in use by {}", holder(path));
        return Err(Error::invalid(what, "one that no other process writes to", got));
    }
    // The name is for people only, so a full disk is no reason to stop.
    lock.set_len(0).and_then(|()| lock.write_all(own_name().as_bytes())).unwrap_or_default();
    Ok(lock)
}

/// What this process writes into a lock: always the same name, even if the machine is renamed
/// meanwhile.
fn own_name() -> &'static str {
    static NAME: OnceLock<String> = OnceLock::new();
    let name = || format!("process {} on {}\n", std::process::id(), gethostname().display());
    NAME.get_or_init(name)
}

/// An error unless the folder of this name is the one that this process has locked.
pub(crate) fn check_held(path: &Path) -> Result<()> {
    let got = match fs::read_to_string(path.join(LOCK)) {
        // On a full disk it contains no name.
        Ok(name) if name.is_empty() || name == own_name() => return Ok(()),
        Ok(name) => format!("that of {}", name.trim()),
        // Somebody removed the lock but left the run.
        Err(_) if path.join("config.toml").is_file() => return Ok(()),
        Err(_) => "none".to_owned(),
    };
    let what = format!("run folder '{}', moved or deleted in the meantime", path.display());
    Err(Error::invalid(what, "the one that this run began in", got))
}

/// The process that writes to a run's folder now, such as `process 4711 on node3`; `None` if there
/// is none. The system releases a lock when its process ends, however it ends, so a lock is never
/// stale.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("first");
/// use copq::Method;
/// use copq_experiments::{Plan, RunFolder, held_by};
///
/// let method = Method::cop_td3();
/// let folder = RunFolder::create(&path, &Plan::new(&method), &method.config)?;
/// assert!(held_by(&path).is_some_and(|who| who.starts_with("process ")));
/// drop(folder);
/// assert_eq!(held_by(&path), None);
/// # Ok::<(), copq::Error>(())
/// ```
pub fn held_by(path: &Path) -> Option<String> {
    let lock = File::open(path.join(LOCK)).ok()?;
    // Shared, so that two processes that only look do not see each other.
    match lock.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Some(holder(path)),
        Ok(()) | Err(TryLockError::Error(_)) => None,
    }
}

/// The last process that wrote into a lock.
fn holder(path: &Path) -> String {
    match fs::read_to_string(path.join(LOCK)).unwrap_or_default().trim() {
        "" => "another process".to_owned(),
        name => name.to_owned(),
    }
}
