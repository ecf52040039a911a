//! Ctrl-C, `kill`, a closed terminal and a cluster's warning as a flag that the training loop
//! checks between two steps.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use copq::{Error, Result};
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGUSR1};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// The flags of the process's handlers. The handlers are installed once and stay, because a handler
/// cannot be removed; while no run trains they do what would have happened without them.
#[derive(Clone, Default)]
struct Flags {
    /// No run trains: a signal does what it did before.
    idle: Arc<AtomicBool>,
    /// A signal came while a run trained.
    asked: Arc<AtomicBool>,
    /// One of them was SIGINT; the next SIGINT ends the process.
    interrupted: Arc<AtomicBool>,
}

/// The handlers' flags, once there are handlers, and how many runs train.
static RUNNING: Mutex<(Option<Flags>, usize)> = Mutex::new((None, 0));

/// Catches SIGINT, SIGTERM, SIGHUP and SIGUSR1 (Slurm's warning before a limit) for as long as it
/// lives; a second SIGINT ends the process at once. (The others may come twice by themselves: from
/// a terminal's shell and from the terminal.) A signal that the process was told to ignore, as by
/// `nohup`, stays ignored.
///
/// A [`Run`](crate::Run) catches signals by itself while it trains; a program that holds its own
/// `Stop` does not miss one before that.
///
/// ```
/// use copq_experiments::Stop;
///
/// let stop = Stop::catch()?; // from here on Ctrl-C is a request, not the end
/// assert!(!stop.is_asked());
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Stop(Flags);

impl Stop {
    /// Begins to catch signals.
    pub fn catch() -> Result<Self> {
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        let (flags, count) = &mut *running;
        let flags = match flags {
            Some(flags) => flags,
            None => flags.insert(install().map_err(|e| Error::other("catching signals", e))?),
        };
        if *count == 0 {
            flags.asked.store(false, Ordering::SeqCst);
            flags.interrupted.store(false, Ordering::SeqCst);
            flags.idle.store(false, Ordering::SeqCst);
        }
        *count += 1;
        Ok(Self(flags.clone()))
    }

    /// Whether a signal has come.
    pub fn is_asked(&self) -> bool {
        self.0.asked.load(Ordering::Relaxed)
    }

    /// Whether a signal was SIGINT, so that one more ends the process.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.0.interrupted.load(Ordering::Relaxed)
    }

    /// An error once a signal has come.
    pub(crate) fn check(&self) -> Result<()> {
        if self.is_asked() {
            return Err(Error::Unsupported { what: "stopped by a signal".to_owned() });
        }
        Ok(())
    }
}

impl Drop for Stop {
    fn drop(&mut self) {
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        running.1 -= 1;
        if running.1 == 0 {
            self.0.idle.store(true, Ordering::SeqCst);
        }
    }
}

impl fmt::Debug for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stop").field("asked", &self.is_asked()).finish_non_exhaustive()
    }
}

fn install() -> std::io::Result<Flags> {
    let flags = Flags::default();
    let signals = [
        SIGINT,
        SIGTERM,
        #[cfg(unix)]
        SIGHUP,
        #[cfg(unix)]
        SIGUSR1,
    ];
    for signal in signals {
        let before = Disposition::of(signal);
        if before == Disposition::Ignored {
            continue;
        }
        // Handlers run in this order, so that the first signal only sets the flag.
        if before == Disposition::Default {
            flag::register_conditional_default(signal, flags.idle.clone())?;
            if signal == SIGINT {
                // 128 + signal is the shell's convention. Only a second SIGINT counts: a SIGTERM
                // that comes with the first one, as from a pool of runs, does not.
                let second = flags.interrupted.clone();
                flag::register_conditional_shutdown(signal, 128 + signal, second)?;
                flag::register(signal, flags.interrupted.clone())?;
            }
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
    /// The program that we are part of has a handler, which is called along with ours.
    Caught,
}

impl Disposition {
    /// As Linux reports it; elsewhere it is unknown, and the default is assumed.
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
