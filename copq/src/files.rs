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

/// Replaces a file's content with `bytes`, atomically.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_with(path, |part| {
        File::create(part)
            .and_then(|mut file| file.write_all(bytes))
            .map_err(failed("writing", part))
    })
}

/// Lets `write` make a file under a temporary name, then gives it its real name: written, synced,
/// renamed, folder synced. If this fails, the temporary file is removed, so that a full disk gets
/// its space back.
pub fn replace_with(path: &Path, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    replace_by(&part_of(path), path, write)
}

/// Like [`replace_with`], for a file that several programs may write at once. Each uses its own
/// temporary name. What a killed program leaves behind stays.
pub fn replace_shared(path: &Path, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    // The extension stays: some formats are recognised by it.
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
        // The first failure says more than a failure to remove the temporary file would.
        fs::remove_file(part).unwrap_or_default();
    }
    replaced?;
    sync_folder_of(path)
}

/// `.name.part` beside the file. What a crash leaves there is overwritten by the next write.
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
