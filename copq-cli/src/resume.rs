//! `copq resume`: continues from the last checkpoint.

use std::path::PathBuf;

use copq_experiments::OnResume;

use crate::keeping::Keeping;
use crate::options::{note, positive};
use crate::python::PythonProcess;
use crate::saved;
use crate::training::{leave, train};

/// Resumes a run from its last checkpoint, as if it had never stopped.
///
/// Its numbers differ from an unbroken run's where it continues with a new episode (in Python
/// environments, and after an environment error) or without a replay (from a checkpoint that has
/// none, see --replay).
///
/// Method, task, seed and settings are the run's own. As in training, Ctrl-C saves and
/// exits with code 75.
#[derive(clap::Args)]
pub struct Resume {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// Total environment steps to train for, not fewer than the run's own. A step size that has
    /// decayed to its final value stays there. [default: the run's own]
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    steps: Option<u64>,

    /// Go back to the checkpoint before the last one, or to the next older one that is sound.
    ///
    /// The last one is kept as checkpoint.damaged.safetensors, or as checkpoint.later.safetensors
    /// if it is sound.
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
            note("its environment cannot be saved: a new episode begins, all else is as it was");
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
