//! COP-Q on TD3: a robot learns to be safe first, fast second, frugal third.
//!
//! `cargo run --release --example td3` trains the hopper on rapier; `--help` explains the rest.

use clap::Parser;
use copq::{Config, Critic, Learner, Projection, Rng, Stream, Trainer, projection};
use copq_examples::make_env;
use copq_experiments::{Args, Plan, Run};

/// Trains TD3 with vector-valued critics, whose disagreement a projection turns into one cautious bound (COP-Q).
///
/// Leaves a folder with settings, metrics.csv, TensorBoard events, curves and a checkpoint. Ctrl-C saves and exits;
/// --resume goes on, bit for bit.
#[derive(Parser)]
#[command(name = "td3")]
struct Cli {
    #[command(flatten)]
    args: Args,

    /// Environment steps with uniformly random actions before learning begins. [default: 1000]
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    start_steps: Option<u64>,

    /// Explore with Gaussian noise alone (TD3), not towards the upper bound of the critics (COP-OAC).
    #[arg(long, conflicts_with = "resume")]
    gaussian: bool,
}

fn main() -> anyhow::Result<()> {
    let Cli { args, start_steps, gaussian } = Cli::parse();

    // The settings: TD3's preset, the options over it, or with --resume what the run's folder holds.
    let preset = Config::td3();
    let start_steps = start_steps.unwrap_or(preset.start_steps);
    let optimism = preset.optimism.filter(|_| !gaussian);
    let config = args.settings(Config { start_steps, optimism, ..preset })?;
    let mut plan = args.plan(Plan::new("td3"))?;
    plan.run.discount = config.discount;

    // The world, twice: to learn in, and to be evaluated in.
    let env = make_env(&plan)?;
    let spec = env.spec().clone();

    // The networks: as many critics as the projection wants, N values each, and a deterministic actor. Independent
    // double-Q alone has separate networks for each objective.
    let projection = projection::by_name(&plan.projection)?;
    let mut rng = Rng::new(plan.run.seed, Stream::Init);
    let (objectives, critics) = (spec.objectives.len(), projection.critics(spec.objectives.len()));
    let critic: Box<dyn Critic> = if projection.name() == "independent-min" {
        let counts = vec![critics; objectives];
        Box::new(copq_candle::separate_critics(&spec, &counts, &config.networks, plan.threads, &mut rng)?)
    } else {
        Box::new(copq_candle::critic(&spec, critics, &config.networks, &mut rng)?.threads(plan.threads)?)
    };
    let actor = copq_candle::actor(&spec, &config.networks, &mut rng)?.threads(plan.threads)?;

    // The learner. Swapping the projection is this one line.
    let learner = Learner::new(config.clone(), &spec, critic, Box::new(actor), plan.run.seed)?;
    let learner = learner.projection(projection);

    // Train, and leave everything in a folder.
    let folder = args.open(&plan, &config)?;
    let trainer = Trainer::new(env, Box::new(learner), plan.run.seed)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}
