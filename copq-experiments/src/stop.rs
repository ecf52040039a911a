//! Ctrl-C and `kill` as a flag that the training loop looks at between two steps.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use copq::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{SigId, flag, low_level};

/// Catches SIGINT and SIGTERM for as long as it lives; a second signal ends the process at once.
pub(crate) struct Stop {
    asked: Arc<AtomicBool>,
    handlers: Vec<SigId>,
}

impl Stop {
    pub(crate) fn catch() -> Result<Self> {
        let mut stop = Self { asked: Arc::default(), handlers: Vec::new() };
        for signal in [SIGINT, SIGTERM] {
            // Handlers run in this order, so that the first signal only sets the flag. 128 + signal
            // is the shell's custom.
            let end = flag::register_conditional_shutdown(signal, 128 + signal, stop.asked.clone());
            stop.handlers.push(end.map_err(|e| Error::other("catching signals", e))?);
            let set = flag::register(signal, stop.asked.clone());
            stop.handlers.push(set.map_err(|e| Error::other("catching signals", e))?);
        }
        Ok(stop)
    }

    pub(crate) fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}

impl Drop for Stop {
    fn drop(&mut self) {
        self.handlers.drain(..).for_each(|handler| {
            low_level::unregister(handler);
        });
    }
}

impl fmt::Debug for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stop").field("asked", &self.is_asked()).finish_non_exhaustive()
    }
}
