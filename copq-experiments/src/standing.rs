//! How far a run has come, from the ends of its files.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::folder::read_done;
use crate::lock::held_by;

/// How much of a file's end to read first: most last rows are shorter.
const TAIL: u64 = 1 << 14;

/// Where a run stands.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("first");
/// use copq::Method;
/// use copq_experiments::{Plan, RunFolder, Standing};
///
/// assert_eq!(Standing::of(&path), Standing::Waiting);
/// let method = Method::cop_td3();
/// let folder = RunFolder::create(&path, &Plan::new(&method), &method.config)?;
/// assert!(matches!(Standing::of(&path), Standing::Running(who) if who.starts_with("process ")));
/// drop(folder);
/// assert_eq!(Standing::of(&path), Standing::Stopped);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Standing {
    /// It has not begun.
    Waiting,
    /// A process is running it: [`held_by`].
    Running(String),
    /// It can be resumed.
    Stopped,
    /// An error ended it.
    Failed(String),
    /// It has all its steps.
    Done,
}

impl Standing {
    /// The standing of the run that is, or will be, in a folder. Only the ends of files are read,
    /// so that thousands of runs can be checked.
    pub fn of(folder: &Path) -> Self {
        if read_done(folder).is_some() {
            return Self::Done;
        }
        if let Some(who) = held_by(folder) {
            return Self::Running(who);
        }
        match failure(folder) {
            Some(error) => Self::Failed(error),
            None if folder.join("config.toml").is_file() => Self::Stopped,
            None => Self::Waiting,
        }
    }

    /// The standing in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Running(_) => "running",
            Self::Stopped => "stopped",
            Self::Failed(_) => "failed",
            Self::Done => "done",
        }
    }

    /// What else there is to say: which process runs it, or what went wrong.
    pub fn remark(&self) -> Option<&str> {
        match self {
            Self::Running(remark) | Self::Failed(remark) => Some(remark),
            _ => None,
        }
    }
}

/// Where a program that starts runs as processes keeps what a failed one wrote to standard error:
/// beside the run's folder, which may not exist.
pub fn complaint_file(folder: &Path) -> PathBuf {
    folder.with_added_extension("err")
}

/// Why a run failed the last time: its process's error or last line, or the error that its log ends
/// with.
pub fn failure(folder: &Path) -> Option<String> {
    complaint(folder).or_else(|| {
        let log = tail(&folder.join("log.txt"))?;
        log.lines().last()?.strip_prefix("error: ").map(str::to_owned)
    })
}

fn complaint(folder: &Path) -> Option<String> {
    let text = tail(&complaint_file(folder))?;
    let error = text.lines().find_map(|line| line.strip_prefix("Error: "));
    let last = text.lines().rfind(|line| !line.trim().is_empty());
    let memory = text.lines().find(|line| line.starts_with("memory allocation of "));
    panic(&text).or_else(|| memory.or(error).or(last).map(str::to_owned))
}

/// Where a process panicked, and what it said then.
fn panic(text: &str) -> Option<String> {
    let mut lines = text.lines();
    let place =
        lines.find_map(|line| line.strip_prefix("thread '")?.split_once(" panicked at "))?.1;
    Some(format!("panicked at {place} {}", lines.next().unwrap_or_default()))
}

/// Steps that a run has reported in `metrics.csv`, 0 if it has none.
pub fn steps_done(folder: &Path) -> u64 {
    let last = |text: String| {
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().last()?.split(',').next()?.parse().ok()
    };
    tail(&folder.join("metrics.csv")).and_then(last).unwrap_or(0)
}

/// The end of a file, however long it is: at least its last whole line.
fn tail(path: &Path) -> Option<String> {
    let mut file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    let mut size = TAIL;
    loop {
        file.seek(SeekFrom::Start(length.saturating_sub(size))).ok()?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).ok()?;
        // A line lies between two ends, or begins the file.
        let ends = bytes.iter().filter(|&&byte| byte == b'\n').count();
        if ends > 1 || size >= length {
            return Some(String::from_utf8_lossy(&bytes).into_owned());
        }
        size *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_last_whole_row() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("metrics.csv");
        assert_eq!(steps_done(folder.path()), 0);
        for (text, wanted) in [
            ("", 0),
            ("step,a\n", 0),
            ("step,a\n1000,0.5\n", 1_000),
            ("step,a\n1000,0.5\n2000,0.", 1_000),
            (&format!("step,a\n1000,{}\n2000,1\n", "9".repeat(40_000)), 2_000),
            (&format!("step,a\n1000,1\n2000,{}\n", ",5".repeat(40_000)), 2_000),
            (&format!("step,a\n1000,1\n2000{}", ",5".repeat(40_000)), 1_000),
        ] {
            std::fs::write(&file, text).unwrap();
            assert_eq!(steps_done(folder.path()), wanted);
        }
    }

    #[test]
    fn why_it_failed() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path().join("run");
        std::fs::create_dir(&folder).unwrap();
        assert_eq!(failure(&folder), None);
        let log = folder.join("log.txt");
        std::fs::write(&log, "error: old\nfrom step 0 to 10\n").unwrap();
        assert_eq!(failure(&folder), None, "it has gone on since");
        std::fs::write(&log, "from step 0 to 10\nerror: no room\n").unwrap();
        assert_eq!(failure(&folder).as_deref(), Some("no room"));
        let words = complaint_file(&folder);
        std::fs::write(&words, "note: a\nError: settings differ\n\nCaused by: b\n").unwrap();
        assert_eq!(Standing::of(&folder), Standing::Failed("settings differ".to_owned()));
        let note = "note: run with `RUST_BACKTRACE=1` environment variable to display a backtrace";
        let panic = format!("thread 'main' (7) panicked at a.rs:1:2:\nindex 3 of 2\n{note}\n");
        std::fs::write(&words, format!("step 5: 1.0\n{panic}\nError: ended\n")).unwrap();
        assert_eq!(failure(&folder).as_deref(), Some("panicked at a.rs:1:2: index 3 of 2"));
        let memory = "memory allocation of 7864 bytes failed";
        std::fs::write(&words, format!("{memory}\n\nError: ended by signal: 6\n")).unwrap();
        assert_eq!(failure(&folder).as_deref(), Some(memory));
        std::fs::write(&words, "libphysics: no such file\n\n").unwrap();
        assert_eq!(failure(&folder).as_deref(), Some("libphysics: no such file"));
    }
}
