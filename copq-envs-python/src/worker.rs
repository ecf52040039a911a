//! The child process that an environment lives in, and the socket to it.

use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
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

const PROGRAM: &str = include_str!("worker.py");
/// What an interpreter is started with: it reads the program from the socket, so that lists of
/// processes stay readable.
const START: &str = "\
import os
length = int.from_bytes(os.read(0, 4), 'little')
text = b''
while len(text) < length: text += os.read(0, length - len(text)) or exit(1)
exec(compile(text, '<copq>', 'exec'))";
/// The status that a text follows.
const FAILED: u8 = 255;
/// Longest first line, and longest text of an error.
const LONGEST: u32 = 64 << 20;
/// How long a worker may take to close its environment, or to say where it was.
const GRACE: Duration = Duration::from_secs(3);

/// An environment's process. It ends with this value, and with this program however that ends.
#[derive(Debug)]
pub(crate) struct Worker {
    child: Child,
    socket: BufReader<UnixStream>,
    errors: Errors,
    timeout: Duration,
}

/// Why a worker has not answered.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The environment raised an error; it can be asked again.
    Raised(String),
    /// The worker is of no use any more.
    Lost(String),
}

#[derive(Deserialize)]
#[serde(untagged)]
enum FirstLine {
    Refused { error: String },
    Hello(Hello),
}

impl Worker {
    /// Starts an interpreter with the environment of these settings (JSON); what it says of it.
    pub fn start(
        python: &Path,
        settings: &str,
        timeout: Duration,
    ) -> Result<(Self, Hello), String> {
        let (ours, theirs) = pair(timeout).map_err(|e| format!("no socket for it: {e}"))?;
        let mut child =
            command(python, settings, theirs).spawn().map_err(|e| not_started(python, &e))?;
        let errors = Errors::read(child.stderr.take());
        let mut worker = Self { child, socket: BufReader::new(ours), errors, timeout };
        let hello = worker.send_program().and_then(|()| worker.hello())?;
        worker.errors.show();
        Ok((worker, hello))
    }

    fn send_program(&mut self) -> Result<(), String> {
        let length = (PROGRAM.len() as u32).to_le_bytes();
        let sent = self.socket.get_mut().write_all(&[&length, PROGRAM.as_bytes()].concat());
        sent.map_err(|e| self.lost("its start", &e))
    }

    fn hello(&mut self) -> Result<Hello, String> {
        let mut line = String::new();
        let read = (&mut self.socket).take(LONGEST.into()).read_line(&mut line);
        if let Err(error) = read {
            return Err(self.lost("its start", &error));
        }
        if line.is_empty() {
            return Err(self.lost("its start", &ErrorKind::UnexpectedEof.into()));
        }
        match serde_json::from_str(&line) {
            Ok(FirstLine::Hello(hello)) => Ok(hello),
            Ok(FirstLine::Refused { error }) => Err(error),
            Err(error) => Err(format!("{error} in what its worker said first: {line}")),
        }
    }

    /// Sends a request and reads an answer of this length; returns the status before it.
    pub fn ask(&mut self, request: &[u8], answer: &mut [u8], doing: &str) -> Result<u8, Failure> {
        let mut status = [0];
        let asked = self.socket.get_mut().write_all(request);
        let answered = asked.and_then(|()| self.socket.read_exact(&mut status));
        answered.map_err(|e| Failure::Lost(self.lost(doing, &e)))?;
        if status == [FAILED] {
            return Err(self.raised(doing));
        }
        self.read(answer, doing)?;
        Ok(status[0])
    }

    /// Reads what is left of an answer whose length is known by now.
    pub fn read(&mut self, answer: &mut [u8], doing: &str) -> Result<(), Failure> {
        let read = self.socket.read_exact(answer);
        read.map_err(|e| Failure::Lost(self.lost(doing, &e)))
    }

    fn raised(&mut self, doing: &str) -> Failure {
        match read_text(&mut self.socket) {
            Ok(text) => Failure::Raised(format!("{doing} raised {text}")),
            Err(error) => Failure::Lost(self.lost(doing, &error)),
        }
    }

    /// What became of a worker that did not answer; it is ended.
    fn lost(&mut self, doing: &str, error: &io::Error) -> String {
        let is_silent = matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
        if is_silent {
            // Python's faulthandler then says where it is, even if it is not in Python.
            self.errors.hide();
            let id = Pid::from_child(&self.child);
            kill_process(id, Signal::ABORT).unwrap_or_default();
        }
        let status = self.end();
        let said = self.errors.last_lines();
        if is_silent {
            let seconds = self.timeout.as_secs_f64();
            return format!("{doing} took more than {seconds} s, and was given up{said}");
        }
        let how = status.map_or(String::new(), |status| format!(" ({status})"));
        format!("its Python ended in {doing}{how}{said}")
    }

    /// Waits for the process, and ends it if it takes too long.
    fn end(&mut self) -> Option<ExitStatus> {
        let deadline = Instant::now() + GRACE;
        while Instant::now() < deadline {
            if let Ok(Some(status)) = self.child.try_wait() {
                return Some(status);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        self.child.kill().unwrap_or_default();
        self.child.wait().ok()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // Nobody asks any more: the worker closes its environment and ends.
        self.socket.get_mut().shutdown(Shutdown::Both).unwrap_or_default();
        self.end();
    }
}

fn pair(timeout: Duration) -> io::Result<(UnixStream, UnixStream)> {
    let (ours, theirs) = UnixStream::pair()?;
    ours.set_read_timeout(Some(timeout))?;
    ours.set_write_timeout(Some(timeout))?;
    Ok((ours, theirs))
}

fn command(python: &Path, settings: &str, socket: UnixStream) -> Command {
    let mut command = Command::new(python);
    command.args(["-u", "-c", START, settings]);
    command.stdin(OwnedFd::from(socket)).stdout(Stdio::null()).stderr(Stdio::piped());
    // Ctrl-C is this program's, which saves first.
    command.process_group(0);
    // The order of Python's sets and dictionaries is no reason for other numbers.
    if std::env::var_os("PYTHONHASHSEED").is_none() {
        command.env("PYTHONHASHSEED", "0");
    }
    command
}

fn not_started(python: &Path, error: &io::Error) -> String {
    let python = python.display();
    format!(
        "Python interpreter '{python}': wanted a program that can be started (--python PATH, or the \
         variable COPQ_PYTHON, or a python3 among the programs), got {error}"
    )
}

/// A text with its length before it.
fn read_text(from: &mut impl Read) -> io::Result<String> {
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length).min(LONGEST);
    let mut text = vec![0; length as usize];
    from.read_exact(&mut text)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
