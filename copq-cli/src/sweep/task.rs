//! One run of a sweep: begun, gone on with, or left alone if it is done.

use std::process::exit;

use anyhow::Context;
use copq::files;
use copq_experiments::Ending;

use super::file::SweepFile;
use crate::options::say;
use crate::saved;
use crate::train::train;

/// Stopped, and can go on (EX_TEMPFAIL).
pub const STOPPED: i32 = 75;
/// What is written last into a finished run's folder.
pub const DONE: &str = "DONE";

pub fn run(sweep: &SweepFile, number: usize) -> anyhow::Result<()> {
    let count = sweep.tasks.len();
    let task = sweep.tasks.get(number).with_context(|| {
        format!("--task {number}: wanted one of the file's {count} runs, from 0")
    })?;
    let folder = &task.folder;
    if folder.join(DONE).is_file() {
        return Ok(say(&format!("{} is done\n", folder.display()))?);
    }
    let prepared = task.prepare()?;
    let init = if folder.join("config.toml").is_file() {
        saved::init(folder, &prepared.plan)?
    } else {
        prepared.plan.init_from.as_deref().map(saved::policy_file).transpose()?
    };
    let ending = train(prepared.recipe, prepared.plan, init, |recipe, plan| {
        if folder.join("config.toml").is_file() {
            Ok(recipe.resume(folder, plan)?)
        } else {
            Ok(recipe.create(folder, plan)?)
        }
    })?;
    match ending {
        Ending::Finished { .. } => Ok(files::replace(&folder.join(DONE), b"")?),
        _ => exit(STOPPED),
    }
}
