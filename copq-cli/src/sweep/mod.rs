//! `copq sweep`: many runs from one file, on all cores or on a cluster.

mod cores;
mod file;
mod pool;
mod report;
mod status;
mod submit;
mod task;

use std::path::PathBuf;

use clap::Subcommand;

use crate::options::say;
pub use file::SweepFile;

/// Trains many runs that one file describes: methods, tasks, seeds and whatever else copq train
/// has.
///
/// The same command goes on where the last one stopped, however it stopped; what is done is not
/// done again. A file of twelve runs:
///
/// [all]
/// steps = 20000
///
/// [grid]
/// method = ["cop-td3", "cop-td3-paper"]
/// bound = ["cholesky", "scalarised-min"]
/// seed = [0, 1, 2]
#[derive(clap::Args)]
pub struct Sweep {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    /// Lists the runs of a file, each with its number, its folder and its command.
    Plan(Named),
    Run(pool::Run),
    /// Says which runs are done, which go on, which failed and why.
    Status(Named),
    Submit(submit::Submit),
    Report(report::Report),
    Task(task::One),
}

#[derive(clap::Args)]
struct Named {
    /// The sweep's file, such as experiments/quick.toml.
    file: PathBuf,
}

impl Sweep {
    pub fn run(self) -> anyhow::Result<()> {
        match self.action {
            Action::Plan(Named { file }) => plan(&SweepFile::read(&file)?),
            Action::Run(run) => run.run(),
            Action::Status(Named { file }) => status::print(&SweepFile::read(&file)?),
            Action::Submit(submit) => submit.run(),
            Action::Report(report) => report.run(),
            Action::Task(one) => one.run(),
        }
    }
}

fn plan(sweep: &SweepFile) -> anyhow::Result<()> {
    let mut text = String::new();
    for (i, task) in sweep.tasks.iter().enumerate() {
        text += &format!("{i:>4}  {}  {}\n", task.folder.display(), task.command());
    }
    Ok(say(&text)?)
}
