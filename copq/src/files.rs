//! Reading and replacing whole files so that a crash at any moment leaves the old file or the new
//! one, never a mixture.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// Turns an I/O error into one that says what was being done to which file.
pub fn failed(doing: &str, path: &Path) -> impl FnOnce(io::Error) -> Error {
    let what = format!("{doing} '{}'", path.display());
    move |source| Error::other(what, source)
}

/// The text of a file.
pub fn read_text(path: &Path) -> Result<String> {
    fs::read_to_string(path).map_err(failed("reading", path))
}

/// Replaces a file's content by `bytes`, atomically.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_with(path, |part| {
        File::create(part)
            .and_then(|mut file| file.write_all(bytes))
            .map_err(failed("writing", part))
    })
}

/// Lets `write` make a file under a temporary name, then gives it its real one: written, synced,
/// renamed, folder synced. What cannot be finished is removed again, so that a full disk has its
/// room back.
pub fn replace_with(path: &Path, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    replace_by(&part_of(path), path, write)
}

/// The same for a file that several programs may write at once, each under a temporary name of its
/// own; what a kill leaves of one stays.
pub fn replace_shared(path: &Path, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    // Its ending stays: some formats are told by it.
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    replace_by(&path.with_file_name(format!(".{}.{name}", std::process::id())), path, write)
}

fn replace_by(part: &Path, path: &Path, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    let replaced = write(part).and_then(|()| {
        // Windows syncs only handles that may write.
        let written = File::options().write(true).open(part).map_err(failed("opening", part))?;
        written.sync_all().map_err(failed("syncing", part))?;
        fs::rename(part, path).map_err(failed("replacing", path))
    });
    if replaced.is_err() {
        // Why it failed says more than that its beginning could not be removed either.
        fs::remove_file(part).unwrap_or_default();
    }
    replaced?;
    sync_folder_of(path)
}

/// `.name.part` beside the file: a leftover of a crash is overwritten by the next write.
fn part_of(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.part"))
}

/// Makes a rename in the folder of `path` survive a power failure.
pub fn sync_folder_of(path: &Path) -> Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    // Other systems offer no way to sync a folder, nor do some disks (EINVAL).
    if cfg!(unix) {
        match File::open(folder).and_then(|folder| folder.sync_all()) {
            Err(error) if error.kind() != io::ErrorKind::InvalidInput => {
                return Err(failed("syncing", folder)(error));
            }
            _ => {}
        }
    }
    Ok(())
}
