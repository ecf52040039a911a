//! SAC under a constraint: run as fast as a speed limit allows (COP-Q on CAL, CAL, SACLag-UCB).
//!
//! `cargo run --release --example sac_lagrangian` trains the hopper of benchmark B on rapier; `--help` explains the rest.

use clap::Parser;
use copq::projection::Conservative;
use copq::{Config, Critic, Learner, Rng, Stream, Trainer, projection};
use copq_examples::make_env;
use copq_experiments::{Args, Plan, Run};

/// Trains SAC with a learned Lagrange multiplier that holds the task's cost below its limit.
///
/// --projection cholesky (or another ellipsoid) is COP-Q on CAL, independent-min is SACLag-UCB, and --cal is CAL.
#[derive(Parser)]
#[command(name = "sac_lagrangian")]
struct Cli {
    #[command(flatten)]
    args: Args,

    /// Environment steps with uniformly random actions before learning begins. [default: 10000]
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    start_steps: Option<u64>,

    /// CAL: four cost critics, each with a target of its own, and two reward critics.
    #[arg(long, conflicts_with_all = ["resume", "projection"])]
    cal: bool,
}

fn main() -> anyhow::Result<()> {
    let Cli { args, start_steps, cal } = Cli::parse();

    // The settings: the method's preset, the options over it, or with --resume what the run's folder holds.
    let program = Plan { task: "b/hopper".to_owned(), ..Plan::new("sac_lagrangian") };
    let mut plan = args.plan(program)?;
    let pairs = plan.projection == "independent-min";
    let preset = match (cal, pairs) {
        (true, _) => Config::cal(),
        (_, true) => Config::sac_lagrangian(),
        _ => Config::cop_cal(),
    };
    let start_steps = start_steps.unwrap_or(preset.start_steps);
    let config = args.settings(Config { start_steps, ..preset })?;
    plan.run.discount = config.discount;

    // The world, whose first objective is a cost with a limit, and a stochastic actor.
    let env = make_env(&plan)?;
    let spec = env.spec().clone();
    let (seed, mut rng) = (plan.run.seed, Rng::new(plan.run.seed, Stream::Init));
    let actor = Box::new(copq_candle::gaussian_actor(&spec, &config.networks, &mut rng)?);

    // The critics: scalar ones for each objective (CAL, UCB), or three of cost and reward together (COP-Q).
    let critic: Box<dyn Critic> = if config.own_cost_targets {
        Box::new(copq_candle::separate_critics(&spec, &[4, 2], &config.networks, &mut rng)?)
    } else if pairs {
        Box::new(copq_candle::separate_critics(&spec, &[2, 2], &config.networks, &mut rng)?)
    } else {
        Box::new(copq_candle::critic(&spec, 3, &config.networks, &mut rng)?.threads(plan.threads)?)
    };

    // The learner. A task without a cost is an error here.
    let learner = Learner::new(config.clone(), &spec, critic, actor, seed)?;
    let learner = if config.own_cost_targets {
        learner.projection(Conservative::cal(0.5, 4))
    } else {
        learner.projection(projection::by_name(&plan.projection)?)
    };

    // Train, and leave everything in a folder.
    let folder = args.open(&plan, &config)?;
    let trainer = Trainer::new(env, Box::new(learner), seed)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}
