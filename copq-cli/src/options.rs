//! What comes from the command line, and what goes out to it.

use std::io::{ErrorKind, Write};
use std::path::Path;

use copq::Error;

/// Prints a text; a reader that has seen enough (`copq methods | head`) is no error.
pub fn say(text: &str) -> std::io::Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(std::io::Error::new(e.kind(), format!("writing to standard output: {e}"))),
        Ok(()) => Ok(()),
    }
}

/// Prints a note to standard error; that nobody reads it is no reason to stop.
pub fn note(text: &str) {
    writeln!(std::io::stderr(), "note: {text}").unwrap_or_default();
}

/// An error for a file in a run's folder: output about the run must not overwrite it.
pub fn not_of_a_run(out: &Path) -> Result<(), Error> {
    let folder = out.parent().unwrap_or(Path::new(""));
    if out.exists() && folder.join("config.toml").is_file() {
        let what = format!("'{}'", out.display());
        return Err(Error::invalid(what, "a new file, or one outside a run", "one of a run"));
    }
    Ok(())
}

/// The largest number that a settings file (TOML) can hold.
const LARGEST: u64 = i64::MAX as u64;

/// A whole number from 0 up. By itself, clap would take -1 for an option.
pub fn whole(text: &str) -> Result<u64, String> {
    number_from(0, text)
}

/// A whole number from 1 up.
pub fn positive(text: &str) -> Result<u64, String> {
    number_from(1, text)
}

fn number_from(first: u64, text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(number) if number > LARGEST => Err(format!("wanted at most {LARGEST}")),
        Ok(number) if number >= first => Ok(number),
        _ => Err(format!("wanted a whole number from {first} on")),
    }
}

/// The same as a `usize`, for what is counted in memory.
pub fn count(text: &str) -> Result<usize, String> {
    positive(text).map(|number| number as usize)
}

/// A name and a number, as cost=25.
pub fn number_of(text: &str) -> Result<(String, f64), String> {
    let parts = text.split_once('=').and_then(|(name, value)| Some((name, value.parse().ok()?)));
    match parts {
        Some((name, value)) => Ok((name.to_owned(), value)),
        None => Err("wanted NAME=NUMBER".to_owned()),
    }
}
