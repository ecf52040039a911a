//! The one error type: what was wrong, what was wanted, what came.

use std::fmt;

/// A result whose error is [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong in copq, worded for the person who has to fix it.
///
/// `{:?}` prints the same words as `{}`, so that a `main` that returns [`Result`] ends readably.
///
/// ```
/// use copq::{EnvSpec, Error};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("safety", 2.0);
/// let error = spec.check().unwrap_err();
/// assert!(matches!(error, Error::Invalid { .. }));
/// let words = "cart: objectives: wanted names that differ, got 'safety' twice";
/// assert_eq!(error.to_string(), words);
/// assert_eq!(format!("{error:?}"), words);
/// ```
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting, shape or argument that cannot be used.
    #[error("{what}: wanted {wanted}, got {got}")]
    Invalid {
        /// The setting, slice or argument.
        what: String,
        /// What would have been accepted.
        wanted: String,
        /// What came instead.
        got: String,
    },
    /// A NaN or an infinity where a number belongs.
    #[error("{what} is not finite at step {step}{}: {hint}", in_rows(rows))]
    NonFinite {
        /// The quantity, with the objective's name where it has one.
        what: String,
        /// The learner's update or environment step.
        step: u64,
        /// The first offending rows of the batch (at most eight); empty if no row is to blame.
        rows: Vec<usize>,
        /// What usually causes it.
        hint: &'static str,
    },
    /// A name that is not in a registry.
    #[error("unknown {kind} '{name}'; known: {known}")]
    Unknown {
        /// What the name stands for.
        kind: &'static str,
        /// The name that was asked for.
        name: String,
        /// The names there are, nearest first.
        known: String,
    },
    /// An environment that broke its contract or whose physics failed.
    #[error("environment '{env}': {what}")]
    Env {
        /// The environment's name.
        env: String,
        /// What happened.
        what: String,
    },
    /// Something that this environment, agent or network does not offer.
    #[error("{what}")]
    Unsupported {
        /// What, and which methods would have to be implemented.
        what: String,
    },
    /// A network backend, file format or other library failed.
    #[error("{what}: {cause}")]
    Other {
        /// What was being done.
        what: String,
        /// The library's own error. It is part of the message, and therefore not the `source()`.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Error {
    /// An error that a part has no `save` and `load`, given a description of it and its trait.
    pub(crate) fn cannot_be_saved(what: &str, part: &str) -> Self {
        let what =
            format!("{what} cannot be saved: {part}::save and {part}::load are not implemented");
        Self::Unsupported { what }
    }

    /// An [`Error::Invalid`] from anything printable.
    pub fn invalid(what: impl Into<String>, wanted: impl ToString, got: impl ToString) -> Self {
        Self::Invalid { what: what.into(), wanted: wanted.to_string(), got: got.to_string() }
    }

    /// An [`Error::Unknown`] that lists the known names, those nearest to the wrong one first.
    pub fn unknown(kind: &'static str, name: &str, known: &[&str]) -> Self {
        let mut known = known.to_vec();
        known.sort_by_cached_key(|known| strsim::levenshtein(name, known));
        Self::Unknown { kind, name: name.to_owned(), known: known.join(", ") }
    }

    /// Wraps another library's error with what was being done.
    pub fn other(
        what: impl Into<String>,
        cause: impl Into<Box<dyn std::error::Error + Send + Sync>>,
    ) -> Self {
        Self::Other { what: what.into(), cause: cause.into() }
    }
}

/// An error unless there is at least one of something.
pub fn check_count(what: &str, count: usize) -> Result<()> {
    if count > 0 { Ok(()) } else { Err(Error::invalid(what, "at least 1", count)) }
}

/// Checks a slice's length: `Ok` or an [`Error::Invalid`] that names the slice.
pub fn check_len(what: &str, got: usize, wanted: usize) -> Result<()> {
    if got == wanted { Ok(()) } else { Err(Error::invalid(what, format!("{wanted} values"), got)) }
}

/// An error unless `chosen` names one or more different critics out of `critics`.
pub fn check_chosen(chosen: &[usize], critics: usize) -> Result<()> {
    let repeated = |(i, k)| chosen[..i].contains(k);
    if chosen.is_empty()
        || chosen.iter().any(|&k| k >= critics)
        || chosen.iter().enumerate().any(repeated)
    {
        return Err(Error::invalid(
            "chosen critics",
            format!("different ones below {critics}"),
            format!("{chosen:?}"),
        ));
    }
    Ok(())
}

/// The rows of a batch, if a message has any to name.
fn in_rows(rows: &[usize]) -> String {
    if rows.is_empty() { String::new() } else { format!(", row(s) {rows:?}") }
}

/// An error that names a setting unless it is from 0 to 1.
pub(crate) fn check_fraction(name: &str, value: f64) -> Result<()> {
    check_that((0.0..=1.0).contains(&value), name, "a number from 0 to 1", value)
}

/// An error that names a setting unless it is finite and above 0.
pub(crate) fn check_positive(name: &str, value: f64) -> Result<()> {
    check_that(value.is_finite() && value > 0.0, name, "a positive number", value)
}

/// An error that names a setting unless it is finite and at least 0.
pub(crate) fn check_not_negative(name: &str, value: f64) -> Result<()> {
    check_that(value.is_finite() && value >= 0.0, name, "a finite number, at least 0", value)
}

fn check_that(is_so: bool, name: &str, wanted: &str, value: f64) -> Result<()> {
    if is_so { Ok(()) } else { Err(Error::invalid(name, wanted, value)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_names_come_first() {
        let error = Error::unknown("task", "a/hoper", &["a/ant", "b/hopper", "a/hopper"]);
        assert_eq!(error.to_string(), "unknown task 'a/hoper'; known: a/hopper, b/hopper, a/ant");
    }

    #[test]
    fn rows_are_named_where_there_are_any() {
        let message = |rows: &[usize]| {
            let rows = rows.to_vec();
            let what = "critic loss".to_owned();
            Error::NonFinite { what, step: 7, rows, hint: "lower the step size" }.to_string()
        };
        assert_eq!(message(&[]), "critic loss is not finite at step 7: lower the step size");
        assert_eq!(
            message(&[0, 3]),
            "critic loss is not finite at step 7, row(s) [0, 3]: lower the step size"
        );
    }

    #[test]
    fn both_ways_of_printing_give_the_words() {
        let error = Error::other("reading 'x'", "no such file");
        assert_eq!(
            (format!("{error:?}"), error.to_string()),
            ("reading 'x': no such file".into(), format!("{error}"))
        );
        assert!(std::error::Error::source(&error).is_none(), "its cause would be printed twice");
    }
}
