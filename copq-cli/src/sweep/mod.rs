//! `copq sweep`: many runs from one file, on all cores or on a cluster.

mod cores;
mod file;
mod pool;
mod process;
mod raw;
mod report;
mod slurm;
mod status;
mod submit;
mod task;

use std::path::{Path, PathBuf};

use clap::Subcommand;

use crate::options::say;
pub use file::SweepFile;

/// What a sweep's file looks like.
const FILE: &str = r#"A sweep's file is TOML. Its keys are copq train's long options and `method`:

  title = "Two bounds"       # title of the report
  out = "runs/two-bounds"    # folder of all runs; by default runs/ and the file's name

  [all]                      # options of every run
  steps = 20000
  set = ["batch=128"]        # several --set; those of grid and arms are added

  [grid]                     # one run for each combination of these lists
  task = ["a/hopper", "a/walker2d"]
  seed = [0, 1, 2]

  [[arm]]                    # the whole grid for each arm; its name begins the folder names
  name = "cholesky"

  [[arm]]
  name = "minimum"
  bound = "scalarised-min"
  set = ["tau=0.01"]

  [[exclude]]                # leave out the combinations that have all of these
  name = "minimum"
  seed = 2

  [[include]]                # add this run, with its options on top of [all]
  method = "ppo"
  task = "a/hopper"

  [reference]                # scores that count as 1 where the report takes tasks together
  "a/hopper" = 3042

  [[published]]              # a paper's numbers, shown beside the runs' in the tables
  source = "Table 2"
  task = "a/hopper"
  of = "final"               # or best, best-of-mean, area, last-five (with quantity = "cost")
  seeds = 5
  scores = { cholesky = [3042, 99], minimum = 3020 }    # mean and standard deviation, or mean

  [[claim]]                  # a paper's conclusion, which the report judges by intervals
  says = "it learns faster"
  source = "section 5.1"
  task = ["a/hopper", "a/walker2d"]
  of = "area"                # or final, best, last-five, swing, exceeded (of a quantity)
  method = "cholesky"        # as the report calls it
  is = "above"               # or below; near or not-below, with within = 0.1
  than = "minimum"           # or a list; "limit" is the limit of the cost in quantity

`files = ["other.toml"]` adds the runs of other files; their paths are relative to this file. All
other paths, including `out`, are relative to the folder where copq is called. experiments/ has
examples."#;

/// Trains the runs that a file describes: methods, tasks, seeds and any other option of copq train.
///
/// The same command continues where the last one stopped, however it stopped. What is done is not
/// done again.
#[derive(clap::Args)]
#[command(after_long_help = FILE)]
pub struct Sweep {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    /// Lists the runs of a file, each with its number, its folder, a fingerprint of all that can
    /// change its numbers, and its command.
    Plan(Named),
    Run(pool::Run),
    /// Reports which runs are done, which are running, and which failed and why.
    Status(Named),
    Submit(submit::Submit),
    Report(report::Report),
    Task(task::One),
}

#[derive(clap::Args)]
struct Named {
    /// File of the sweep, such as experiments/quick.toml.
    file: PathBuf,
}

impl Sweep {
    pub fn run(self) -> anyhow::Result<()> {
        match self.action {
            Action::Plan(Named { file }) => plan(&file),
            Action::Run(run) => run.run(),
            Action::Status(Named { file }) => status::print(&SweepFile::read(&file)?),
            Action::Submit(submit) => submit.run(),
            Action::Report(report) => report.run(),
            Action::Task(one) => one.run(),
        }
    }
}

fn plan(file: &Path) -> anyhow::Result<()> {
    let sweep = SweepFile::read_to_begin(file)?;
    let mut text = String::new();
    for (i, task) in sweep.tasks.iter().enumerate() {
        let folder = task.folder.display();
        text += &format!("{i:>4}  {folder}  {}  {}\n", task.fingerprint, task.command());
    }
    Ok(say(&text)?)
}

#[cfg(test)]
mod tests {
    use super::FILE;

    #[test]
    fn the_sample_is_a_file_as_printed() {
        let sample: String = FILE
            .lines()
            .filter_map(|line| line.strip_prefix("  "))
            .map(|l| l.to_owned() + "\n")
            .collect();
        let table: toml::Table = sample.parse().unwrap();
        assert_eq!(table["arm"].as_array().map(Vec::len), Some(2));
        // Terminals wrap help at 100 letters.
        FILE.lines().for_each(|line| assert!(line.len() < 98, "{line}"));
    }
}
