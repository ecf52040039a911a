//! What comes from the command line, and what goes out to it.

use std::io::{ErrorKind, Write};

/// Prints a text; a reader that has seen enough (`copq methods | head`) is no error.
pub fn say(text: &str) -> std::io::Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// A word on the side, on standard error; that nobody listens is no reason to stop.
pub fn note(text: &str) {
    writeln!(std::io::stderr(), "note: {text}").unwrap_or_default();
}

/// A whole number from 0 on. Clap would take the minus of -1 for an option's.
pub fn whole(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| "wanted a whole number from 0 on".to_owned())
}

/// A whole number from 1 on.
pub fn positive(text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err("wanted a whole number from 1 on".to_owned()),
    }
}

/// The same, for what is counted in memory.
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

/// A text as one word of a shell, in quotes where it needs them.
pub fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_quoted_text_is_one_word() {
        assert_eq!(quoted("runs/a-s0"), "runs/a-s0");
        assert_eq!(quoted("networks.hidden=[8, 8]"), "'networks.hidden=[8, 8]'");
        assert_eq!(quoted("/a b/it's"), r"'/a b/it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
