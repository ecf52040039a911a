//! `copq coverage`: how honest a run's bounds are.

use std::path::{Path, PathBuf};

use copq::{Agent, Coverage, Error, Learner, Looks, State};
use copq_candle::Candle;
use copq_experiments::checkpoint_files;

use crate::options::{count, say};
use crate::python::PythonProcess;
use crate::recipe::Recipe;
use crate::saved;
use crate::world::make_env;

/// Says how often what comes is at least as good as the bound that a run's critics put on it.
///
/// Plays episodes of the policy in each checkpoint that the run's folder keeps (copq train --keep), without
/// exploration, and holds the discounted return after an action against what the critics
/// say of it: their mean, the bound that targets use, and their standard deviation. An action whose
/// return is mostly after an episode's time limit is left out. If critics err as they disagree, the
/// error is as large as the standard deviation, and a bound is kept as often as a normal number is
/// above it: 82 % for the paper's 0.92.
#[derive(clap::Args)]
pub struct CoverageOf {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// Episodes to play for each checkpoint.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        value_parser = count,
        allow_negative_numbers = true
    )]
    episodes: usize,

    /// Actions of an episode from one look to the next.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        value_parser = count,
        allow_negative_numbers = true
    )]
    every: usize,

    /// Play with the noise that the targets' actions have (TD3): what critics are taught to value.
    #[arg(long)]
    smoothed: bool,

    /// Print CSV instead of tables.
    #[arg(long)]
    csv: bool,

    #[command(flatten)]
    process: PythonProcess,
}

impl CoverageOf {
    pub fn run(self) -> anyhow::Result<()> {
        let (mut plan, recipe) = saved::run(&self.run)?;
        let Recipe::OffPolicy(method) = recipe else {
            let got = format!("one by {}", plan.method);
            Err(Error::invalid("the run", "one whose critics value actions (off-policy)", got))?
        };
        self.process.over(&mut plan)?;
        let files = checkpoint_files(&self.run)?;
        if self.csv {
            say("step,actions,objective,came,believed,bound,std,error,kept\n")?;
        }
        for file in files {
            let env = make_env(&plan, None, Some(&self.run))?;
            let (candle, seed) = (Candle::default(), plan.run.seed);
            let mut learner = Learner::new(method.clone(), env.spec(), &candle, seed)?;
            let step = load(&mut learner, &file)?;
            let Self { episodes, every, smoothed, .. } = self;
            let coverage = Coverage::of(&mut learner, env, Looks { episodes, every, smoothed })?;
            say(&if self.csv {
                rows(step, &coverage)
            } else {
                format!("step {step}\n{coverage}\n")
            })?;
        }
        Ok(())
    }
}

/// A learner as a checkpoint has it, and its step.
fn load(learner: &mut Learner, file: &Path) -> copq::Result<u64> {
    let checkpoint = State::read_file(file)?;
    let agent = checkpoint.child("trainer")?.child("agent")?;
    learner.load(agent)?;
    agent.get_one("steps")
}

fn rows(step: u64, coverage: &Coverage) -> String {
    let row = |of: &copq::Covered| {
        let copq::Covered { name, came, believed, bound, std, error, kept, .. } = of;
        let actions = coverage.actions;
        format!("{step},{actions},{name},{came},{believed},{bound},{std},{error},{kept}\n")
    };
    coverage.objectives.iter().map(row).collect()
}
