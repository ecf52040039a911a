//! `copq coverage`: how honest a run's bounds are.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use copq::{Agent, Coverage, CoverageConfig, Env, Error, Learner, State, files};
use copq_candle::Candle;
use copq_experiments::{Plan, checkpoint_files};
use serde::Serialize;

use crate::options::{count, say};
use crate::python::PythonProcess;
use crate::recipe::Recipe;
use crate::saved::{self, note_other_versions};
use crate::world::make_env;

/// Reports how often discounted returns are at least as good as the bound of a run's critics.
///
/// Plays episodes of the policy in each checkpoint that the run's folder keeps (copq train --keep),
/// and compares the discounted return after some actions with what the critics predict: mean, bound
/// and standard deviation. The policy is the one that the critics learn to value: with the noise of
/// target smoothing (TD3), or sampled and with its entropy bonus (SAC). Actions so close to the
/// time limit that over a tenth of a return may come after it are left out.
///
/// "coverage" is how often the return is at least as good as the bound (for a cost: at most as
/// large), with a standard error over episodes. "nominal" is what it would be if returns were
/// normal with the critics' mean and standard deviation. The bound is low for the weighted total;
/// for a single objective it may be above the mean. For REDQ it is the bound of all critics, while
/// targets draw two; for CAL's costs it is the actor's, because their targets have none.
#[derive(clap::Args)]
pub struct CoverageCommand {
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

    /// Compare every Nth action of an episode.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        value_parser = count,
        allow_negative_numbers = true
    )]
    stride: usize,

    /// Play the policy without noise, as it is evaluated.
    #[arg(long)]
    bare: bool,

    /// Print CSV instead of tables.
    #[arg(long)]
    csv: bool,

    #[command(flatten)]
    process: PythonProcess,
}

impl CoverageCommand {
    pub fn run(self) -> anyhow::Result<()> {
        let (mut plan, recipe) = saved::run(&self.run)?;
        let Recipe::OffPolicy(method) = recipe else {
            let got = format!("one by {}", plan.method);
            Err(Error::invalid("the run", "one whose critics value actions (off-policy)", got))?
        };
        self.process.over(&mut plan)?;
        // Opened before anything is played, because a run that continues renames them.
        let files = checkpoint_files(&self.run)?.into_iter().map(|path| Ok((open(&path)?, path)));
        let files = files.collect::<copq::Result<Vec<_>>>()?;
        let mut env = make_env(&plan, None, Some(&self.run))?;
        note_other_versions(&plan, env.spec());
        let mut learner = Learner::new(method, env.spec(), &Candle::default(), plan.run.seed)?;
        let Self { episodes, stride, bare, .. } = self;
        let config = CoverageConfig { episodes, stride, bare };
        let mut rows = csv::Writer::from_writer(Vec::new());
        if !self.csv {
            let Plan { method, task, engine, .. } = &plan;
            let seed = plan.run.seed;
            let policy = if bare { "bare" } else { "as it is valued" };
            say(&format!(
                "{method} on {task} ({engine}), {episodes} episodes of seed {seed}, the policy {policy}\n\n"
            ))?;
        }
        for (mut file, path) in files {
            let step = load(&mut learner, &mut file, &path)?;
            let coverage = copq::coverage(&mut learner, &mut env, config)?;
            if self.csv {
                write_rows(&mut rows, step, config, &coverage)?;
            } else {
                say(&format!("step {step}\n{coverage}\n"))?;
            }
        }
        Ok(say(&String::from_utf8(rows.into_inner()?)?)?)
    }
}

fn open(path: &Path) -> copq::Result<File> {
    File::open(path).map_err(files::failed("opening", path))
}

/// Loads a checkpoint into a learner, without the replay; returns its step.
fn load(learner: &mut Learner, file: &mut File, path: &Path) -> copq::Result<u64> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(files::failed("reading", path))?;
    let mut checkpoint = State::from_bytes(path, &bytes)?;
    let agent = checkpoint.child_mut("trainer").child_mut("agent");
    agent.remove_child("replay");
    learner.load(agent)?;
    agent.get_one("steps")
}

fn write_rows(
    rows: &mut csv::Writer<Vec<u8>>,
    step: u64,
    config: CoverageConfig,
    coverage: &Coverage,
) -> csv::Result<()> {
    for of in coverage.objectives.iter().chain([&coverage.total]) {
        rows.serialize(Row {
            step,
            episodes: config.episodes,
            stride: config.stride,
            bare: config.bare,
            actions: coverage.actions,
            objective: &of.name,
            discounted: of.discounted,
            q_mean: of.q_mean,
            bound: of.bound,
            q_std: of.q_std,
            rmse: of.rmse,
            coverage: of.coverage,
            coverage_se: of.coverage_se,
            nominal: of.nominal,
        })?;
    }
    Ok(())
}

#[derive(Serialize)]
struct Row<'a> {
    step: u64,
    episodes: usize,
    stride: usize,
    bare: bool,
    actions: usize,
    objective: &'a str,
    discounted: f64,
    q_mean: f64,
    bound: f64,
    q_std: f64,
    rmse: f64,
    coverage: f64,
    coverage_se: f64,
    nominal: f64,
}
