//! COP-Q on TD3: a robot learns to be safe first, fast second, frugal third.
//!
//! `cargo run --release --example td3` trains the hopper on rapier; `--help` explains the rest.

use clap::Parser;
use copq::{Config, Learner, Rng, Stream, Trainer, projection};
use copq_examples::{make_env, warn_of_limits};
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

    /// Explore with Gaussian noise alone (TD3), not towards the upper bound of the critics (COP-OAC).
    ///
    /// --set optimism.projection=extremum takes another projection's upper bound than --projection's.
    #[arg(long, conflicts_with = "resume")]
    gaussian: bool,
}

fn main() -> anyhow::Result<()> {
    let Cli { args, gaussian } = Cli::parse();

    // The settings: the preset, the options over it, or with --resume what the run's folder holds.
    let method = gaussian.then(|| "td3-gaussian".to_owned());
    let mut plan = args.plan(Plan { method, ..Plan::new("td3") })?;
    let projection = projection::by_name(&plan.projection)?;
    let preset = Config::cop_td3();
    let optimism = preset.optimism.clone().filter(|_| !gaussian);
    let famo = preset.famo.filter(|_| !projection.separate());
    let config = args.settings(Config { optimism, famo, ..preset })?;
    plan.run.discount = config.discount;

    // The world, twice: to learn in, and to be evaluated in.
    let env = make_env(&plan)?;
    let spec = env.spec().clone();
    warn_of_limits(&spec, &config);

    // The networks: the critics that the projection wants, N + 1 of N values each for Cholesky, and a deterministic actor.
    let mut rng = Rng::new(plan.run.seed, Stream::Init);
    let critic = copq_candle::critics_for(projection.as_ref(), &spec, &config.networks, plan.threads, &mut rng)?;
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
