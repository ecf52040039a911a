//! Keeping files under another name, so that nothing is overwritten.

use std::fs;
use std::path::{Path, PathBuf};

use copq::{Result, files};

/// Gives a file a second name, in place of any file that has it. A link costs nothing, but not
/// every disk supports it.
pub(crate) fn link(from: &Path, to: &Path) -> Result<()> {
    fs::remove_file(to).unwrap_or_default();
    let copy = |_| {
        // A network drive may have made the link and say that it has not; copying a file onto
        // itself would empty it.
        fs::remove_file(to).unwrap_or_default();
        fs::copy(from, to).map(drop)
    };
    fs::hard_link(from, to).or_else(copy).map_err(|e| {
        fs::remove_file(to).unwrap_or_default();
        files::failed("keeping", from)(e)
    })
}

/// Gives a file the second name `NAME.safetensors`, or `NAME-2.safetensors` and so on: the first
/// that no file with other content has. Returns it.
pub(crate) fn lay_aside(file: &Path, name: &str) -> Result<PathBuf> {
    let mut other = file.with_file_name(format!("{name}.safetensors"));
    let mut number = 1;
    while other.exists() {
        if is_same(file, &other) {
            return Ok(other);
        }
        number += 1;
        other = file.with_file_name(format!("{name}-{number}.safetensors"));
    }
    link(file, &other)?;
    Ok(other)
}

/// Whether two files have the same content.
pub(crate) fn is_same(a: &Path, b: &Path) -> bool {
    let length = |path: &Path| path.metadata().map(|about| about.len()).ok();
    length(a) == length(b) && fs::read(a).is_ok_and(|a| fs::read(b).is_ok_and(|b| a == b))
}
