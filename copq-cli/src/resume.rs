//! `copq resume`: on from the last checkpoint.

use std::path::PathBuf;

use copq_experiments::{OnEnvError, RunConfig, RunFolder, SavedReplay};

use crate::options::{count, positive};
use crate::saved;
use crate::train::{on_env_error, saved_replay, train};

/// Goes on with a run from its last checkpoint, as if it had never stopped.
///
/// Method, task, seed and settings are the run's own.
#[derive(clap::Args)]
pub struct Resume {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// Environment steps to train for in all, not fewer than the run has. [default: the run's own]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Goes back to the checkpoint before the last one, if that is damaged.
    #[arg(long)]
    previous: bool,

    /// Checkpoints that stay from now on. [default: the run's own]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    keep: Option<usize>,

    /// Which checkpoints hold the replay from now on: all, last or none. [default: the run's own]
    #[arg(long, value_name = "WHICH", value_parser = saved_replay)]
    replay: Option<SavedReplay>,

    /// What to do from now on when the environment fails: stop or reset. [default: the run's own]
    #[arg(long, value_name = "WHAT", value_parser = on_env_error)]
    on_env_error: Option<OnEnvError>,

    /// Threads inside this run; they change no bit of the result. [default: the run's own]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    threads: Option<usize>,
}

impl Resume {
    pub fn run(self) -> anyhow::Result<()> {
        let RunConfig { mut plan, settings, .. } = saved::config(&self.run)?;
        let method = saved::method(&plan, settings)?;
        plan.run.steps = self.steps.unwrap_or(plan.run.steps);
        plan.threads = self.threads.unwrap_or(plan.threads);
        plan.run.keep = self.keep.unwrap_or(plan.run.keep);
        plan.run.replay = self.replay.unwrap_or(plan.run.replay);
        plan.run.on_env_error = self.on_env_error.unwrap_or(plan.run.on_env_error);
        let init = saved::init(&self.run, &plan)?;
        train(method, plan, init, |plan, config| {
            let folder = RunFolder::resume(self.run, plan, config)?;
            if self.previous {
                folder.go_back()?;
            }
            Ok(folder)
        })
    }
}
