//! Every projection on the same robot and seed: what a bound is worth, in one table and one picture.
//!
//! `cargo run --release --example swap_projection` trains each for 20,000 steps on rapier's hopper.

use std::path::{Path, PathBuf};

use clap::Parser;
use copq::{Config, Learner, Rng, Stream, Trainer, projection};
use copq_examples::make_env;
use copq_experiments::{Ending, Labelled, Plan, Run, RunFolder, RunSettings, compare, comparison_table};

/// Trains the same learner under every projection, and compares them.
#[derive(Parser)]
#[command(name = "swap_projection")]
struct Cli {
    /// Environment steps for each.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    steps: u64,

    /// Folder for the runs, the table and the picture; what is there already is not trained again.
    #[arg(long, value_name = "DIR", default_value = "runs/swap_projection")]
    out: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let Cli { steps, out } = Cli::parse();
    let mut runs = Vec::new();
    for &name in projection::names() {
        let run = RunSettings { steps, eval_every: steps.min(5_000), ..RunSettings::default() };
        let plan = Plan { projection: name.to_owned(), run, ..Plan::new("swap_projection") };
        let folder = out.join(name);
        if let Ending::Interrupted { step, .. } = train(&plan, &folder)? {
            anyhow::bail!("stopped and saved at step {step} of {name}; the same command goes on");
        }
        runs.push(Labelled { label: name.to_owned(), folder });
    }
    let table = comparison_table(&runs)?;
    print!("{table}");
    std::fs::write(out.join("table.md"), table)?;
    for picture in ["curves.svg", "curves.png"] {
        compare("Every projection on the same robot", &runs, &[], &out.join(picture))?;
    }
    println!("\neverything is in {}", out.display());
    Ok(())
}

/// One run of COP-Q's learner under a plan's projection.
fn train(plan: &Plan, folder: &Path) -> copq::Result<Ending> {
    let (env, seed, steps) = (make_env(plan)?, plan.run.seed, plan.run.steps);
    let projection = projection::by_name(&plan.projection)?;

    // What a projection decides besides itself: which critics it wants, and with that whether FAMO has anything to balance.
    let preset = Config::cop_td3().for_projection(&projection);
    let config = Config { start_steps: (steps / 4).clamp(1, 1_000), ..preset };
    let (spec, mut rng) = (env.spec().clone(), Rng::new(seed, Stream::Init));
    let critic = copq_candle::critics_for(projection.as_ref(), &spec, &config.networks, 1, &mut rng)?;
    let actor = copq_candle::actor(&spec, &config.networks, &mut rng)?;
    let learner = Learner::new(config.clone(), &spec, critic, Box::new(actor), seed)?.projection(projection);

    let make = if folder.exists() { RunFolder::resume } else { RunFolder::create };
    let folder = make(folder, plan, &config)?;
    Run::new(Trainer::new(env, Box::new(learner), seed)?, make_env(plan)?, folder, plan.run)?.train()
}
