//! The program as a command, and what it says.

use std::process::{Command, Output, Stdio};

pub fn copq() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_copq"));
    command.env("RUST_BACKTRACE", "0").stdin(Stdio::null());
    command
}

/// What it writes to standard error.
pub fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn assert_well(output: &Output) {
    assert!(output.status.success(), "{:?}: {}", output.status, words(output));
}
