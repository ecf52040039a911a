//! How a training run ended.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::numbers::grouped;

/// How [`Run::train`](crate::Run::train) ended; prints as a sentence for the user.
///
/// ```
/// use copq_experiments::Ending;
///
/// let ending = Ending::Interrupted { step: 12_000, folder: "runs/first".into() };
/// assert_eq!(
///     ending.to_string(),
///     "stopped and saved at step 12,000; go on with RunFolder::resume(\"runs/first\", ..)"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// All steps are done.
    Finished {
        /// The run's folder.
        folder: PathBuf,
    },
    /// A signal came; the checkpoint is of that moment.
    Interrupted {
        /// Environment steps done.
        step: u64,
        /// The run's folder.
        folder: PathBuf,
    },
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finished { folder } => {
                write!(f, "finished; everything is in {}", folder.display())
            }
            Self::Interrupted { step, folder } => {
                write!(
                    f,
                    "stopped and saved at step {}; go on with {}",
                    grouped(*step),
                    resume_command(folder)
                )
            }
        }
    }
}

/// How to resume the run in a folder: the command line of copq's own program, or the call that the
/// author of another program uses.
pub(crate) fn resume_command(folder: &Path) -> String {
    if is_copq() {
        format!("copq resume {}", quoted(&folder.to_string_lossy()))
    } else {
        format!("RunFolder::resume({folder:?}, ..)")
    }
}

/// How to resume from the checkpoint before the newest.
pub(crate) fn go_back_command(folder: &Path) -> String {
    if is_copq() {
        format!("copq resume {} --previous", quoted(&folder.to_string_lossy()))
    } else {
        "RunFolder::go_back".to_owned()
    }
}

fn is_copq() -> bool {
    let program = std::env::current_exe().unwrap_or_default();
    // Linux's name for a file that another has replaced.
    let names = ["copq", "copq (deleted)"];
    program.file_stem().is_some_and(|name| names.iter().any(|known| name == *known))
}

/// A text as one shell word, in quotes if it needs them.
///
/// ```
/// assert_eq!(copq_experiments::quoted("runs/a b"), "'runs/a b'");
/// ```
pub fn quoted(text: &str) -> String {
    // In Windows' shells a path is plain, and single quotes do not quote.
    let is_plain = |c: char| {
        c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c) || cfg!(windows) && c == '\\'
    };
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    if cfg!(windows) {
        return format!("\"{text}\"");
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
