//! `copq resume`: on from the last checkpoint.

use std::path::PathBuf;

use copq_experiments::OnResume;

use crate::keeping::Keeping;
use crate::options::{note, positive};
use crate::python::PythonProcess;
use crate::saved;
use crate::training::{leave, train};

/// Goes on with a run from its last checkpoint, as if it had never stopped.
///
/// To other numbers it goes on with a new episode, in worlds of Python's and after an error of a
/// world, and without a replay, where the checkpoint has none (--replay).
///
/// Method, task, seed and settings are the run's own. Ctrl-C saves and exits with code 75 again.
#[derive(clap::Args)]
pub struct Resume {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// Environment steps to train for in all, not fewer than the run has. A step size that has
    /// fallen to its end stays there. [default: the run's own]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Goes back to the checkpoint before the last one, or to the next one before that is sound.
    /// The last one stays as checkpoint.damaged.safetensors, or as checkpoint.later.safetensors if
    /// it is sound.
    #[arg(long)]
    previous: bool,

    #[command(flatten)]
    keeping: Keeping,

    #[command(flatten)]
    process: PythonProcess,
}

impl Resume {
    pub fn run(self) -> anyhow::Result<()> {
        let (mut plan, recipe) = saved::run(&self.run)?;
        plan.run.steps = self.steps.unwrap_or(plan.run.steps);
        self.keeping.over(&mut plan);
        self.process.over(&mut plan)?;
        if plan.run.on_resume == OnResume::NewEpisode {
            note("its world cannot be saved: it goes on with a new episode, all else as it was");
        }
        let init = saved::init(&self.run, &plan)?;
        let ending = train(recipe, plan, init, Some(&self.run), |recipe, plan| {
            saved::note_other_build(&self.run);
            let mut folder = recipe.resume(&self.run, plan)?;
            if self.previous && folder.go_back()? {
                note("the last checkpoint is sound: it is kept as checkpoint.later.safetensors");
            }
            Ok(folder)
        })?;
        leave(&ending)
    }
}
