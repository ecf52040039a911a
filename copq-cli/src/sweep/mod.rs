//! `copq sweep`: many runs from one file, on all cores.

mod file;
mod pool;
mod status;
mod task;

use std::path::PathBuf;

use clap::Subcommand;

use crate::options::{count, say};
use file::SweepFile;

/// Trains many runs that one file describes: methods, tasks, seeds and whatever else copq train
/// has.
///
/// The same command goes on where the last one stopped, however it stopped; what is done is not
/// done again. A file of twelve runs:
///
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
    /// Trains all that is not done yet, several at once. Ctrl-C saves them all.
    Run(Run),
    /// Says which runs are done, which go on, which failed and why.
    Status(Named),
    /// Trains one run of a file; 75 as exit code means that it was stopped, and can go on.
    Task(One),
}

#[derive(clap::Args)]
struct Named {
    /// The sweep's file, such as experiments/quick.toml.
    file: PathBuf,
}

#[derive(clap::Args)]
struct Run {
    #[command(flatten)]
    named: Named,

    /// Runs at the same time, a process each. [default: one a core]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    jobs: Option<usize>,
}

#[derive(clap::Args)]
struct One {
    #[command(flatten)]
    named: Named,

    /// The run's number, counted from 0 as copq sweep plan does.
    #[arg(long, value_name = "N")]
    task: usize,
}

impl Sweep {
    pub fn run(self) -> anyhow::Result<()> {
        match self.action {
            Action::Plan(Named { file }) => {
                let sweep = SweepFile::read(&file)?;
                let mut text = String::new();
                for (i, task) in sweep.tasks.iter().enumerate() {
                    text += &format!("{i:>4}  {}  {}\n", task.folder.display(), task.command());
                }
                Ok(say(&text)?)
            }
            Action::Run(Run { named, jobs }) => pool::run(&named.file, jobs),
            Action::Status(Named { file }) => status::print(&SweepFile::read(&file)?),
            Action::Task(One { named, task }) => task::run(&SweepFile::read(&named.file)?, task),
        }
    }
}
