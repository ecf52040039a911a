//! The child process that an environment lives in, and the socket to it.

use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde::Deserialize;

use crate::errors::Errors;
use crate::hello::Hello;

/// What an interpreter is started with. It reads the program from the socket, so that process lists
/// stay readable. Any version of Python can read this.
const START: &str = "\
import os, struct, sys
if sys.version_info < (3, 8):
    sys.exit('wanted Python 3.8 or newer, got %s (%s)' % (sys.version.split()[0], sys.executable))
length = struct.unpack('<I', os.read(0, 4))[0]
text = b''
while len(text) < length: text += os.read(0, length - len(text)) or sys.exit(1)
exec(compile(text, '<copq>', 'exec'))";
const PROGRAM: &str = include_str!("worker.py");
/// The status that a text follows.
const FAILED: u8 = 255;
/// Longest text that is accepted.
const LONGEST: u32 = 64 << 20;
/// How often a silent worker is checked.
const LOOK: Duration = Duration::from_millis(200);
/// How long a worker may take to close its environment, or to say where it was; its guard waits as
/// long.
const GRACE: Duration = Duration::from_secs(5);
/// A start imports a lot, perhaps on a busy machine: it may take this many times as long as a step.
const START_TIMES: u32 = 5;

/// An environment's process. It ends with this value, and with this program, however the program
/// ends.
#[derive(Debug)]
pub(crate) struct Worker {
    child: Child,
    socket: UnixStream,
    errors: Errors,
    timeout: Duration,
}

/// Why a worker has not answered.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The environment raised an error; it can be asked again.
    Raised(String),
    /// The worker can no longer be used.
    Lost(String),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum First {
    Refused { error: String },
    Hello(Hello),
}

impl Worker {
    /// Starts an interpreter with the environment of these settings (JSON). Also returns what the
    /// worker says about it.
    pub fn start(
        python: &Path,
        settings: &str,
        timeout: Duration,
    ) -> Result<(Self, Hello), String> {
        let (socket, theirs) = pair().map_err(|e| format!("creating its socket: {e}"))?;
        let mut child =
            command(python, settings, theirs).spawn().map_err(|e| not_started(python, &e))?;
        let errors = Errors::read(child.stderr.take());
        let mut worker = Self { child, socket, errors, timeout: START_TIMES * timeout };
        let hello = worker.hello()?;
        worker.errors.show();
        worker.timeout = timeout;
        Ok((worker, hello))
    }

    fn hello(&mut self) -> Result<Hello, String> {
        let length = (PROGRAM.len() as u32).to_le_bytes();
        let sent = self.socket.write_all(&[&length, PROGRAM.as_bytes()].concat());
        let said = sent.and_then(|()| self.text()).map_err(|e| self.lost("its start", &e))?;
        match serde_json::from_str(&said) {
            Ok(First::Hello(hello)) => Ok(hello),
            Ok(First::Refused { error }) => Err(error),
            Err(error) => Err(format!("{error} in its worker's first message: {said}")),
        }
    }

    /// Sends a request and reads an answer of this length; returns the status before it.
    pub fn ask(&mut self, request: &[u8], answer: &mut [u8], doing: &str) -> Result<u8, Failure> {
        let mut status = [0];
        let asked = self.socket.write_all(request);
        let answered = asked.and_then(|()| self.fill(&mut status));
        answered.map_err(|e| Failure::Lost(self.lost(doing, &e)))?;
        if status == [FAILED] {
            return Err(match self.text() {
                Ok(text) => Failure::Raised(format!("{doing} raised {text}")),
                Err(error) => Failure::Lost(self.lost(doing, &error)),
            });
        }
        self.read(answer, doing)?;
        Ok(status[0])
    }

    /// Reads what is left of an answer whose length is known by now.
    pub fn read(&mut self, answer: &mut [u8], doing: &str) -> Result<(), Failure> {
        self.fill(answer).map_err(|e| Failure::Lost(self.lost(doing, &e)))
    }

    /// Reads a text preceded by its length.
    fn text(&mut self) -> io::Result<String> {
        let mut length = [0; 4];
        self.fill(&mut length)?;
        let length = u32::from_le_bytes(length);
        if length > LONGEST {
            // What is left unread would be taken for the next answer.
            return Err(ErrorKind::InvalidData.into());
        }
        let mut text = vec![0; length as usize];
        self.fill(&mut text)?;
        Ok(String::from_utf8_lossy(&text).into_owned())
    }

    /// Fills `bytes`, as long as the worker is there and not silent for too long.
    fn fill(&mut self, bytes: &mut [u8]) -> io::Result<()> {
        let mut filled = 0;
        let mut heard = Instant::now();
        while filled < bytes.len() {
            match self.socket.read(&mut bytes[filled..]) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => {
                    filled += count;
                    heard = Instant::now();
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                // Its own children can hold the socket longer than it lives.
                Err(error) if is_late(&error) && self.has_ended() => {
                    return Err(ErrorKind::UnexpectedEof.into());
                }
                Err(error) if is_late(&error) && heard.elapsed() < self.timeout => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Ends a worker that did not answer; returns what became of it.
    fn lost(&mut self, doing: &str, error: &io::Error) -> String {
        let is_silent = is_late(error);
        if is_silent {
            // Python's faulthandler then says where it is, even if it is not in Python.
            self.errors.hide();
            let id = Pid::from_child(&self.child);
            kill_process(id, Signal::ABORT).unwrap_or_default();
        }
        let status = self.end();
        // Its guard, which holds standard error open, ends when the socket closes.
        self.socket.shutdown(Shutdown::Both).unwrap_or_default();
        let said = self.errors.last_lines();
        if is_silent {
            let seconds = self.timeout.as_secs_f64();
            return format!(
                "{doing} took more than {seconds} s and was stopped (--env-timeout sets how long \
                 to wait){said}"
            );
        }
        let how = status.map_or(String::new(), |status| format!(" ({status})"));
        format!("its Python process ended during {doing}{how}{said}")
    }

    fn has_ended(&mut self) -> bool {
        !matches!(self.child.try_wait(), Ok(None))
    }

    /// Waits for the process, and ends it if it takes too long.
    fn end(&mut self) -> Option<ExitStatus> {
        let deadline = Instant::now() + GRACE;
        while Instant::now() < deadline && !self.has_ended() {
            std::thread::sleep(Duration::from_millis(2));
        }
        self.child.kill().unwrap_or_default();
        self.child.wait().ok()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // Nobody asks any more: the worker closes its environment and ends.
        self.socket.shutdown(Shutdown::Both).unwrap_or_default();
        self.end();
    }
}

fn is_late(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

fn pair() -> io::Result<(UnixStream, UnixStream)> {
    let (ours, theirs) = UnixStream::pair()?;
    ours.set_read_timeout(Some(LOOK))?;
    // Requests are small, and fit the system's buffer.
    ours.set_write_timeout(Some(GRACE))?;
    Ok((ours, theirs))
}

fn command(python: &Path, settings: &str, socket: UnixStream) -> Command {
    let mut command = Command::new(python);
    command.args(["-u", "-c", START, settings]);
    command.stdin(OwnedFd::from(socket)).stdout(Stdio::null()).stderr(Stdio::piped());
    // Ctrl-C is for this program, which saves first.
    command.process_group(0);
    // The order of Python's sets and dictionaries must not change the numbers.
    if std::env::var_os("PYTHONHASHSEED").is_none() {
        command.env("PYTHONHASHSEED", "0");
    }
    command
}

fn not_started(python: &Path, error: &io::Error) -> String {
    let shown = python.display();
    if python.is_dir() {
        let meant = python.join("bin/python");
        return format!(
            "Python interpreter: wanted a program such as {}, got {shown}",
            meant.display()
        );
    }
    format!(
        "Python interpreter '{shown}': wanted a program that can be started (--python PATH, the \
         variable COPQ_PYTHON, or else python3 on the PATH), got {error}"
    )
}
