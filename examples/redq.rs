//! REDQ: ten critics and twenty updates a step; with --oac the critics say where to look (REDQ + COP-OAC).
//!
//! `cargo run --release --example redq` trains the hopper on rapier; `--help` explains the rest.

use clap::Parser;
use copq::{Config, Learner, Optimism, Rng, Stream, Trainer};
use copq_examples::{make_env, warn_of_limits};
use copq_experiments::{Args, Plan, Run};

/// Critics of the ensemble; every target is made by two of them, drawn at random.
const CRITICS: usize = 10;

/// Trains randomised ensembled double-Q with vector-valued critics, explored by the policy's own noise.
///
/// With --oac it explores where the critics promise the most, by --projection's upper bound: cholesky is COP-OAC, extremum
/// Extremum-OAC.
#[derive(Parser)]
#[command(name = "redq")]
struct Cli {
    #[command(flatten)]
    args: Args,

    /// Explore towards the upper bound of --projection.
    #[arg(long, conflicts_with = "resume")]
    oac: bool,

    /// REDQ on SAC, with a stochastic policy, instead of on TD3.
    #[arg(long, conflicts_with = "resume")]
    sac: bool,
}

fn main() -> anyhow::Result<()> {
    let Cli { args, oac, sac } = Cli::parse();
    if args.projection.is_some() && args.resume.is_none() && !oac {
        anyhow::bail!("--projection: wanted --oac beside it (it names the upper bound that explores)");
    }

    // The settings: TD3's or SAC's, with REDQ's over them.
    let base = if sac { Config::sac() } else { Config::cop_td3_paper() };
    let method = ["redq", if sac { "-sac" } else { "" }, if oac { "-oac" } else { "" }].concat();
    let mut plan = args.plan(Plan { method: Some(method), ..Plan::new("redq") })?;
    let optimism = Optimism { projection: Some(plan.projection.clone()), ..Optimism::default() };
    let config = args.settings(Config { optimism: oac.then_some(optimism), ..base.redq() })?;
    plan.run.discount = config.discount;
    if args.resume.is_none() && oac != config.optimism.is_some() {
        anyhow::bail!("--oac and the settings disagree: wanted optimism with --oac and none without");
    }
    if args.resume.is_none() {
        // Whose upper bound explores in the end: --set may have changed it.
        let explores = config.optimism.as_ref().and_then(|optimism| optimism.projection.clone());
        plan.projection = explores.unwrap_or_else(|| "scalarised-min".to_owned());
    }

    // The world, and the networks: ten critics of N values each, and an actor.
    let env = make_env(&plan)?;
    let spec = env.spec().clone();
    warn_of_limits(&spec, &config);
    let mut rng = Rng::new(plan.run.seed, Stream::Init);
    let critic = copq_candle::critic(&spec, CRITICS, &config.networks, &mut rng)?.threads(plan.threads)?;
    let actor = copq_candle::actor_for(&config, &spec, plan.threads, &mut rng)?;

    // The learner: its targets take the smaller of two random critics, its actor the mean of all ten; with --oac all ten
    // explore, by the upper bound of another projection than that of the targets.
    let learner = Learner::new(config.clone(), &spec, Box::new(critic), actor, plan.run.seed)?;

    // Train, and leave everything in a folder.
    let folder = args.open(&plan, &config)?;
    let trainer = Trainer::new(env, Box::new(learner), plan.run.seed)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}
