//! The newest checkpoint of a run and those before it.

use std::fs;
use std::path::{Path, PathBuf};

use copq::{Error, Result, State, files};

use crate::aside::{is_same, lay_aside, link};
use crate::ending::go_back_command;
use crate::settings::{MAX_KEEP, RunSettings, SavedReplay};

/// A run folder's checkpoints: how many are kept, and which of them hold the replay.
#[derive(Debug)]
pub(crate) struct Checkpoints {
    folder: PathBuf,
    keep: usize,
    replay: SavedReplay,
    /// Where a run that goes back will resume.
    back: Option<Back>,
}

/// The name of a checkpoint that does not read back well, once a run has gone back to an older one.
const DAMAGED: &str = "checkpoint.damaged";

/// An older checkpoint that is to become the newest.
#[derive(Clone, Copy, Debug)]
struct Back {
    age: usize,
    /// The name that the newest then gets: it is damaged, or left on purpose.
    aside: &'static str,
}

impl Checkpoints {
    pub(crate) fn new(folder: &Path, run: &RunSettings) -> Self {
        Self { folder: folder.to_owned(), keep: run.keep, replay: run.replay, back: None }
    }

    /// Replaces the checkpoint; the new one is read back before it takes its place. Older ones
    /// become `checkpoint.1.safetensors` and so on.
    pub(crate) fn save(&self, state: &State) -> Result<()> {
        let newest = self.file(0);
        let aside = self.before();
        let has_older = self.keep > 1 && newest.exists();
        if has_older {
            link(&newest, &aside)?;
        }
        let saved = state.write_file(&newest);
        if saved.is_err() {
            remove_if_there(&aside);
        }
        saved?;
        if has_older {
            self.age(&aside)?;
        }
        for age in self.keep..=MAX_KEEP {
            remove_if_there(&self.file(age));
        }
        Ok(())
    }

    /// Makes the former newest checkpoint the one before the newest, and all others older.
    fn age(&self, aside: &Path) -> Result<()> {
        if self.replay == SavedReplay::Last
            && let Ok(mut older) = State::read_file(aside)
        {
            remove_replay(&mut older);
            older.write_file(aside)?;
        }
        // Up to the first that is missing: what a kill left half done is not done twice.
        let gap = (1..self.keep - 1).find(|&age| !self.file(age).exists());
        for age in (1..gap.unwrap_or(self.keep - 1)).rev() {
            move_if_there(&self.file(age), &self.file(age + 1))?;
        }
        move_if_there(aside, &self.file(1))
    }

    /// The file that a run resumes from.
    pub(crate) fn start(&self) -> PathBuf {
        self.file(self.back.map_or(0, |back| back.age))
    }

    /// The last checkpoint, or the one to go back to; none if the run was stopped before the first.
    /// The error for a damaged or lost one says whether there is one before it.
    pub(crate) fn load(&self) -> Result<Option<State>> {
        if self.back.is_some() {
            return State::read_file(self.start()).map(Some);
        }
        let path = self.file(0);
        let older = self.older();
        if !path.exists() && older.is_none() {
            return Ok(None);
        }
        State::read_file(&path).map(Some).map_err(|e| {
            match older.map(|age| State::read_file(self.file(age))) {
                None | Some(Err(_)) => e,
                Some(Ok(_)) => {
                    let command = go_back_command(&self.folder);
                    let advice = format!(
                        "the last checkpoint cannot be read, but {command} resumes from the one \
                         before it"
                    );
                    Error::other(advice, e)
                }
            }
        })
    }

    /// Makes the run resume from the newest sound checkpoint before the last one. Returns whether
    /// the last one reads back well. Until [`Checkpoints::take_up`], files move only to finish what
    /// a kill left half done.
    pub(crate) fn go_back(&mut self) -> Result<bool> {
        self.tidy()?;
        let what = format!("run folder '{}'", self.folder.display());
        let mut error = Error::invalid(what, "a checkpoint before the last", "none");
        for age in (1..=MAX_KEEP).filter(|&age| self.file(age).exists()) {
            match State::read_file(self.file(age)) {
                Ok(_) => {
                    let is_sound = State::read_file(self.file(0)).is_ok();
                    let aside = if is_sound { "checkpoint.later" } else { DAMAGED };
                    self.back = Some(Back { age, aside });
                    return Ok(is_sound);
                }
                Err(damaged) => error = damaged,
            }
        }
        Err(error)
    }

    /// Where the newest checkpoint waits while another takes its place.
    fn before(&self) -> PathBuf {
        self.folder.join(".checkpoint.before")
    }

    /// Finishes what a kill left half done: puts the checkpoint before the newest in its place, if
    /// it is a different one and whole. (One that cannot be read stays until the next one is
    /// saved.)
    fn tidy(&self) -> Result<()> {
        let before = self.before();
        if self.keep == 1 || is_same(&before, &self.file(0)) {
            remove_if_there(&before);
        } else if before.exists() && State::read_file(&before).is_ok() {
            return self.age(&before);
        }
        Ok(())
    }

    /// Makes the checkpoint that a run goes back to the newest.
    pub(crate) fn take_up(&mut self) -> Result<()> {
        self.tidy()?;
        let Some(Back { age, aside }) = self.back else { return Ok(()) };
        let newest = self.file(0);
        if newest.exists() {
            lay_aside(&newest, aside)?;
        }
        for damaged in (1..age).map(|age| self.file(age)).filter(|file| file.exists()) {
            lay_aside(&damaged, DAMAGED)?;
            remove_if_there(&damaged);
        }
        // There is a newest one at every moment.
        move_if_there(&self.file(age), &newest)?;
        for older in age + 1..=MAX_KEEP {
            move_if_there(&self.file(older), &self.file(older - age))?;
        }
        self.back = None;
        Ok(())
    }

    /// The age of the checkpoint before the newest.
    fn older(&self) -> Option<usize> {
        (1..=MAX_KEEP).find(|&age| self.file(age).exists())
    }

    fn file(&self, age: usize) -> PathBuf {
        file(&self.folder, age)
    }
}

/// The file of a folder's checkpoint that is `age` checkpoints older than the newest.
fn file(folder: &Path, age: usize) -> PathBuf {
    match age {
        0 => folder.join("checkpoint.safetensors"),
        _ => folder.join(format!("checkpoint.{age}.safetensors")),
    }
}

/// The last checkpoint of the run in a folder, for programs that only look: the run may continue
/// meanwhile.
pub fn read_checkpoint(folder: &Path) -> Result<State> {
    let newest = file(folder, 0);
    if newest.is_file() { State::read_file(&newest) } else { Err(without(folder)) }
}

/// All checkpoints that a run's folder keeps, the oldest first. An error if there is none.
pub fn checkpoint_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let files = (0..=MAX_KEEP).rev().map(|age| file(folder, age));
    let there: Vec<_> = files.filter(|file| file.is_file()).collect();
    if there.is_empty() { Err(without(folder)) } else { Ok(there) }
}

fn without(folder: &Path) -> Error {
    let what = format!("run folder '{}'", folder.display());
    let wanted = "one with a checkpoint (runs write it every --checkpoint-every steps, on Ctrl-C \
         and at their end)";
    Error::invalid(what, wanted, "one without")
}

/// Takes the replay out of a checkpoint.
pub(crate) fn remove_replay(checkpoint: &mut State) {
    checkpoint.child_mut("trainer").child_mut("agent").remove_child("replay");
}

/// Removes a file if possible; one that stays is only in the way.
fn remove_if_there(path: &Path) {
    fs::remove_file(path).unwrap_or_default();
}

fn move_if_there(from: &Path, to: &Path) -> Result<()> {
    if !from.exists() {
        return Ok(());
    }
    fs::rename(from, to).map_err(files::failed("moving", from))?;
    files::sync_folder_of(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoints_come_oldest_first_and_none_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let error = checkpoint_files(folder.path()).unwrap_err().to_string();
        assert!(error.contains("wanted one with a checkpoint"), "{error}");
        let names =
            ["checkpoint.10.safetensors", "checkpoint.2.safetensors", "checkpoint.safetensors"];
        for name in names {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let wanted = names.map(|name| folder.path().join(name));
        assert_eq!(checkpoint_files(folder.path()).unwrap(), wanted);
    }
}
