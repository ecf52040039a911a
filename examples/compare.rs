//! Two methods over several seeds, each run in a folder of its own. If you interrupt it, the same
//! command resumes where it stopped.
//!
//! `cargo run --release -p copq-examples --example compare` leaves `runs/compare`.

use std::path::{Path, PathBuf};

use copq::projection::ScalarisedMin;
use copq::{Agent, Learner, Method, Result, Trainer};
use copq_candle::Candle;
use copq_experiments::statistics::{Sample, area_under};
use copq_experiments::{
    Ending, Plan, ReportRun, Run, RunFolder, RunSettings, Sheet, compare, comparison_table,
};

const TASK: &str = "a/hopper";

/// Trains one seed to its end, from wherever it stopped, and returns its folder.
fn train(method: Method, seed: u64, steps: u64) -> Result<PathBuf> {
    let run =
        RunSettings { steps, seed, eval_every: (steps / 10).max(1), ..RunSettings::default() };
    // What names the run: the words in a plan are yours to choose, and nothing checks them.
    let plan = Plan { task: TASK.to_owned(), run, ..Plan::new(&method) };
    let path = Path::new("runs/compare").join(plan.folder_name());
    let config = method.config.clone();
    let folder = match path.join("config.toml").exists() {
        true => RunFolder::resume(&path, &plan, &config)?,
        false => RunFolder::create(&path, &plan, &config)?,
    };
    let env = copq_envs_rapier::make(TASK)?;
    let learner = Learner::new(method, env.spec(), &Candle::default(), seed)?;
    let agent: Box<dyn Agent> = Box::new(learner); // a run takes any agent
    let trainer = Trainer::new(env, agent)?;
    match Run::new(trainer, Some(copq_envs_rapier::make(TASK)?), folder, run)?.train()? {
        Ending::Finished { .. } => Ok(path),
        stopped => {
            println!("{stopped}");
            std::process::exit(75)
        }
    }
}

/// The mean total of a run's evaluations.
fn mean_total(folder: &Path) -> Result<f64> {
    let sheet = Sheet::read(&folder.join("evaluations.csv"))?;
    let steps: Vec<f64> = sheet.steps().iter().map(|&step| step as f64).collect();
    Ok(area_under(&steps, &sheet.column("weighted_total/mean").unwrap_or_default()))
}

fn main() -> Result<()> {
    let steps = copq_examples::steps(20_000)?;
    let warm_up = steps.min(1_000).div_ceil(2);
    let mut runs = Vec::new();
    let mut totals = [Vec::new(), Vec::new()];
    for seed in 0..3 {
        let cholesky = Method::cop_td3().warm_up(warm_up);
        let minimum = Method::cop_td3().bound(ScalarisedMin).warm_up(warm_up);
        for (method, totals) in [cholesky, minimum].into_iter().zip(&mut totals) {
            let label = method.bound.name();
            let folder = train(method, seed, steps)?;
            totals.push(mean_total(&folder)?);
            runs.push(ReportRun::new(folder).called(label));
        }
    }
    print!("{}", comparison_table(&runs, None)?);
    compare("Two bounds", &runs, &[].into(), Path::new("runs/compare/compare.svg"))?;
    let [ours, theirs] = totals.map(|totals| Sample::of(&totals));
    if let Some([low, high]) = ours.difference(&theirs) {
        println!("cholesky's mean total is {low:.0} to {high:.0} higher (95 %, three seeds each)");
    }
    Ok(())
}
