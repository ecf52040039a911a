//! Ctrl-C, `kill` and a closed terminal as a flag that the training loop looks at between two steps.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use copq::{Error, Result};
#[cfg(unix)]
use signal_hook::consts::SIGHUP;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// What the process's handlers look at. They are installed once and stay, for a handler cannot be
/// taken back; while no run trains they do what would have happened without them.
#[derive(Debug, Default)]
struct Flags {
    /// Nobody trains: a signal does what it did before.
    idle: Arc<AtomicBool>,
    /// A signal came while a run trained.
    asked: Arc<AtomicBool>,
    /// Runs that train.
    running: AtomicUsize,
}

static FLAGS: OnceLock<Flags> = OnceLock::new();

/// Catches SIGINT, SIGTERM and SIGHUP for as long as it lives; a second signal ends the process at
/// once. A signal that the process was told to ignore, as by `nohup`, stays ignored.
#[derive(Debug)]
pub(crate) struct Stop(&'static Flags);

impl Stop {
    pub(crate) fn catch() -> Result<Self> {
        let flags = match FLAGS.get() {
            Some(flags) => flags,
            None => {
                let flags = install().map_err(|e| Error::other("catching signals", e))?;
                FLAGS.get_or_init(|| flags)
            }
        };
        if flags.running.fetch_add(1, Ordering::SeqCst) == 0 {
            flags.asked.store(false, Ordering::SeqCst);
            flags.idle.store(false, Ordering::SeqCst);
        }
        Ok(Self(flags))
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.0.asked.load(Ordering::Relaxed)
    }
}

impl Drop for Stop {
    fn drop(&mut self) {
        if self.0.running.fetch_sub(1, Ordering::SeqCst) == 1 {
            self.0.idle.store(true, Ordering::SeqCst);
        }
    }
}

fn install() -> std::io::Result<Flags> {
    let flags = Flags::default();
    let signals = [
        SIGINT,
        SIGTERM,
        #[cfg(unix)]
        SIGHUP,
    ];
    for signal in signals {
        let before = Disposition::of(signal);
        if before == Disposition::Ignored {
            continue;
        }
        // Handlers run in this order, so that the first signal only sets the flag. 128 + signal is
        // the shell's custom.
        if before == Disposition::Default {
            flag::register_conditional_default(signal, flags.idle.clone())?;
            flag::register_conditional_shutdown(signal, 128 + signal, flags.asked.clone())?;
        }
        flag::register(signal, flags.asked.clone())?;
    }
    Ok(flags)
}

/// What a process does about a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Disposition {
    /// What the system does: it ends the process.
    Default,
    Ignored,
    /// A handler of the program that we are part of, which is called with ours.
    Caught,
}

impl Disposition {
    /// As Linux tells it; elsewhere nobody does, and the usual is supposed.
    fn of(signal: i32) -> Self {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let has = |field: &str| {
            let mask = status.lines().find_map(|line| line.strip_prefix(field));
            let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
            mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
        };
        match (has("SigIgn:"), has("SigCgt:")) {
            (true, _) => Self::Ignored,
            (_, true) => Self::Caught,
            _ => Self::Default,
        }
    }
}
