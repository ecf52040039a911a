//! Values on the command line, whose errors say what is wanted.

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
