//! The program as a command, and what it says.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Options of a tiny run.
pub const TINY: &str = "--eval-every 50 --eval-episodes 1 --log-every 10 \
                        --set networks.hidden=[8,8] --set batch=8 --set start_steps=40";

pub fn copq() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_copq"));
    command.env("RUST_BACKTRACE", "0").stdin(Stdio::null());
    command
}

/// The program in a folder, with the words of a line.
pub fn copq_in(folder: &Path, line: &str) -> Command {
    let mut command = copq();
    command.args(line.split(' ')).current_dir(folder);
    command
}

/// What it writes to standard error.
pub fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn assert_well(output: &Output) {
    assert!(output.status.success(), "{:?}: {}", output.status, words(output));
}

pub fn well(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", words(&output));
    output
}

/// What it prints when all goes well.
pub fn printed(command: &mut Command) -> String {
    String::from_utf8(well(command).stdout).unwrap()
}

/// What it says when it fails.
pub fn refused(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(!output.status.success(), "{command:?}");
    words(&output)
}

/// What it prints in a folder, of a line, when all goes well.
pub fn run(folder: &Path, line: &str) -> String {
    printed(&mut copq_in(folder, line))
}

pub fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(60), "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
