//! What a worker writes to standard error.

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::process::ChildStderr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Bytes that are kept.
const KEPT: usize = 16 << 10;
/// Bytes that are shown to the user.
const PASSED_ON: usize = 1 << 20;
/// Lines that an error shows.
const SHOWN: usize = 12;
/// How long to wait for the rest of what was written.
const GRACE: Duration = Duration::from_secs(1);

/// The last of what a worker wrote. From [`Errors::show`] on, the first megabyte also goes to this
/// program's standard error.
#[derive(Debug)]
pub(crate) struct Errors {
    kept: Arc<Mutex<Kept>>,
    reader: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Kept {
    bytes: VecDeque<u8>,
    is_shown: bool,
    /// Bytes that have been shown.
    shown: usize,
}

impl Errors {
    /// Keeps reading in its own thread, so that writers never wait.
    pub fn read(from: Option<ChildStderr>) -> Self {
        let kept = Arc::new(Mutex::new(Kept::default()));
        let to = Arc::clone(&kept);
        let reader = from.map(|from| std::thread::spawn(move || read_on(from, &to)));
        Self { kept, reader }
    }

    /// Shows output from now on.
    pub fn show(&self) {
        lock(&self.kept).is_shown = true;
    }

    /// Keeps output from now on only for error messages.
    pub fn hide(&self) {
        lock(&self.kept).is_shown = false;
    }

    /// The last lines of a worker that has ended, to append to a sentence.
    pub fn last_lines(&self) -> String {
        let deadline = Instant::now() + GRACE;
        while self.reader.as_ref().is_some_and(|reader| !reader.is_finished())
            && Instant::now() < deadline
        {
            std::thread::sleep(Duration::from_millis(2));
        }
        let bytes: Vec<u8> = lock(&self.kept).bytes.iter().copied().collect();
        let text = String::from_utf8_lossy(&bytes);
        // Python adds a list of modules, the longest and least informative of its lines.
        let says = |line: &&str| !line.trim().is_empty() && !line.starts_with("Extension modules:");
        let lines: Vec<_> = text.lines().filter(says).collect();
        if lines.is_empty() {
            return String::new();
        }
        let last = &lines[lines.len().saturating_sub(SHOWN)..];
        format!("; its last output:\n  {}", last.join("\n  "))
    }
}

fn read_on(mut from: ChildStderr, to: &Mutex<Kept>) {
    let mut bytes = [0; 4096];
    while let Ok(count) = from.read(&mut bytes)
        && count > 0
    {
        let mut kept = lock(to);
        kept.bytes.extend(&bytes[..count]);
        let surplus = kept.bytes.len().saturating_sub(KEPT);
        kept.bytes.drain(..surplus);
        if kept.is_shown && kept.shown < PASSED_ON {
            kept.shown += count;
            pass_on(&bytes[..count], kept.shown >= PASSED_ON);
        }
    }
}

/// Shows what an environment wrote. It does not matter if nobody listens.
fn pass_on(bytes: &[u8], is_last: bool) {
    let mut out = std::io::stderr();
    out.write_all(bytes).unwrap_or_default();
    if is_last {
        let text = "\nnote: the environment has written a megabyte; further output is not shown\n";
        out.write_all(text.as_bytes()).unwrap_or_default();
    }
}

/// The bytes are intact even if a thread panicked meanwhile.
fn lock(kept: &Mutex<Kept>) -> MutexGuard<'_, Kept> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}
