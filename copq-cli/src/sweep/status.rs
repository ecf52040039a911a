//! What has become of a sweep's runs.

use std::path::Path;

use copq_experiments::{Sheet, is_in_use};

use super::file::{SweepFile, Task};
use super::task::DONE;
use crate::options::say;

/// Where a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Waiting,
    Running,
    Stopped,
    Failed,
    Done,
}

impl State {
    pub fn of(folder: &Path) -> Self {
        if folder.join(DONE).is_file() {
            Self::Done
        } else if !folder.join("config.toml").is_file() {
            Self::Waiting
        } else if is_in_use(folder) {
            Self::Running
        } else if failure(folder).is_some() {
            Self::Failed
        } else {
            Self::Stopped
        }
    }
}

/// The error that a run ended with last, as its log has it.
pub fn failure(folder: &Path) -> Option<String> {
    let log = std::fs::read_to_string(folder.join("log.txt")).ok()?;
    log.lines().last()?.strip_prefix("error: ").map(str::to_owned)
}

/// Steps that a run has reported.
pub fn steps(folder: &Path) -> u64 {
    let sheet = Sheet::read(&folder.join("metrics.csv")).ok();
    sheet.and_then(|sheet| sheet.steps().last().copied()).unwrap_or(0)
}

pub fn print(sweep: &SweepFile) -> anyhow::Result<()> {
    let mut text =
        "| run | state | steps | of | weighted total |\n|---|---|--:|--:|--:|\n".to_owned();
    for task in &sweep.tasks {
        text += &row(task)?;
    }
    for task in &sweep.tasks {
        if let (State::Failed, Some(error)) = (State::of(&task.folder), failure(&task.folder)) {
            text += &format!("\n{}: {error}\n", task.folder.display());
        }
    }
    Ok(say(&text)?)
}

fn row(task: &Task) -> anyhow::Result<String> {
    let folder = &task.folder;
    let total = Sheet::read(&folder.join("evaluations.csv")).ok();
    let total = total.and_then(|sheet| sheet.column("weighted_total/mean")?.last().copied());
    let total = total.map_or(String::new(), |total| format!("{total:.1}"));
    let state = format!("{:?}", State::of(folder)).to_lowercase();
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let all = task.prepare()?.plan.run.steps;
    Ok(format!("| {name} | {state} | {} | {all} | {total} |\n", steps(folder)))
}
