//! One run of a sweep: started, resumed, or left alone if it is done.

use std::fs;
use std::path::Path;
use std::process::exit;

use anyhow::{bail, ensure};
use copq::files;
use copq_experiments::{Ending, Stop, complaint_file, held_by, read_plan};

use super::cores;
use super::file::{SweepFile, Task};
use crate::options::{note, say};
use crate::saved;
use crate::training::{STOPPED, train};

/// Exit code if another process has the run (EX_CANTCREAT).
pub const HELD: i32 = 73;

/// Trains one run of a file.
///
/// Exit code 75 means that it was stopped and can be resumed, 73 that another process has it.
#[derive(clap::Args)]
pub struct One {
    #[command(flatten)]
    named: super::Named,

    /// Number of the run, counted from 0 as in copq sweep plan.
    #[arg(long, value_name = "N")]
    task: usize,

    /// Fingerprint that the run must have: the file may have changed since.
    #[arg(long, value_name = "LETTERS", hide = true)]
    expect: Option<String>,

    /// Processor to stay on.
    #[arg(long, value_name = "N", hide = true)]
    core: Option<usize>,
}

impl One {
    pub fn run(self) -> anyhow::Result<()> {
        // Before all else: a signal must not end a process that does not listen yet.
        let stop = Stop::catch()?;
        cores::be_called_copq();
        if let Some(core) = self.core {
            cores::stay_on(core);
        }
        let task = SweepFile::read_task(&self.named.file, self.task, self.expect.as_deref())?;
        run(&task, &stop)
    }
}

fn run(task: &Task, stop: &Stop) -> anyhow::Result<()> {
    let folder = &task.folder;
    if task.is_done() {
        return Ok(say(&format!("{} is done\n", folder.display()))?);
    }
    leave_if_held(folder);
    // What was said about an earlier failure is no longer true.
    fs::remove_file(complaint_file(folder)).unwrap_or_default();
    let ending = begin_or_go_on(task);
    match ending {
        Ok(Ending::Finished { .. }) => Ok(()),
        Ok(_) => exit(STOPPED),
        Err(error) => {
            // Another process may have been quicker between the look and the lock.
            leave_if_held(folder);
            if stop.is_asked() {
                note(&format!("{error:#}"));
                exit(STOPPED)
            }
            complain(folder, &error);
            Err(error)
        }
    }
}

/// Writes the reason of a failure beside the folder, which may be full or missing. If that also
/// fails, standard error already has it.
fn complain(folder: &Path, error: &anyhow::Error) {
    let text = format!("Error: {error:#}\n");
    files::replace(&complaint_file(folder), text.as_bytes()).unwrap_or_default();
}

/// Ends the process if another one has the run.
fn leave_if_held(folder: &Path) {
    if let Some(who) = held_by(folder) {
        note(&format!("{} belongs to {who}", folder.display()));
        exit(HELD);
    }
}

fn begin_or_go_on(task: &Task) -> anyhow::Result<Ending> {
    let folder = &task.folder;
    let mut prepared = task.prepare()?;
    let is_there = folder.join("config.toml").is_file();
    if let Some(why) = task.why_only_anew() {
        bail!(why);
    }
    ensure!(
        task.submitted.as_ref().is_none_or(|then| *then == task.fingerprint),
        "the policy that it begins with has changed since it was submitted; submit it again"
    );
    let init = if is_there {
        prepared.plan.versions = read_plan(folder)?.versions;
        saved::init(folder, &prepared.plan)?
    } else {
        prepared.plan.init_from.as_deref().map(saved::policy_file).transpose()?
    };
    let run = is_there.then_some(folder.as_path());
    train(prepared.recipe, prepared.plan, init, run, |recipe, plan| {
        if is_there {
            saved::note_other_build(folder);
            Ok(recipe.resume(folder, plan)?)
        } else {
            Ok(recipe.create(folder, plan)?)
        }
    })
}
