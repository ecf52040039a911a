//! SAC under a constraint: run as fast as a speed limit allows.
//!
//! `cargo run --release --example sac_lagrangian` trains the hopper of benchmark B on rapier; `--help` explains the rest.

use clap::{Parser, ValueEnum};
use copq::projection::{Conservative, IndependentMin};
use copq::{Config, Constraint, Critic, Learner, PidConfig, Projection, Rng, Stream, Trainer, projection};
use copq_examples::{make_env, warn_of_limits};
use copq_experiments::{Args, Plan, Run};

/// Trains SAC with a multiplier that holds the task's cost below its limit.
#[derive(Parser)]
#[command(name = "sac_lagrangian")]
struct Cli {
    #[command(flatten)]
    args: Args,

    /// Who values cost and reward, how cautiously, and who sets the multiplier. With --resume it is the run's.
    #[arg(long, value_enum, default_value = "cop-cal", conflicts_with = "resume")]
    method: Method,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// COP-Q on CAL: three critics of cost and reward together, and the bound of --projection.
    CopCal,
    /// CAL: four cost critics, each with a target of its own, and two reward critics.
    Cal,
    /// CAL with its authors' constants: small batches, ten updates a step.
    CalOriginal,
    /// SACLag-UCB: two cost critics, of which the larger counts, and two reward critics.
    SaclagUcb,
    /// SAC-Lagrangian: one cost critic and two reward critics.
    SacLagrangian,
    /// SAC-Lagrangian with a PID controller for the multiplier.
    SacPid,
    /// SAC that knows no limit, for any task; --set optimism.projection=extremum makes it OAC.
    Sac,
}

/// A method's settings, its critics of each cost and of each reward if they are separate, and its own projection if any.
type Parts = (Config, Option<[usize; 2]>, Option<Box<dyn Projection>>);

impl Method {
    fn parts(self) -> Parts {
        let pid = Config { constraint: Some(Constraint::Pid(PidConfig::default())), ..Config::sac() };
        let cal = |config| -> Parts { (config, Some([4, 2]), Some(Box::new(Conservative::cal(0.5, 4)))) };
        let least = |config, counts| -> Parts { (config, Some(counts), Some(Box::new(IndependentMin))) };
        match self {
            Self::CopCal => (Config::cop_cal(), None, None),
            Self::Cal => cal(Config::cal()),
            Self::CalOriginal => cal(Config::cal_original()),
            Self::SaclagUcb => least(Config::sac_lagrangian(), [2, 2]),
            Self::SacLagrangian => least(Config::sac_lagrangian(), [1, 2]),
            Self::SacPid => least(pid, [1, 2]),
            Self::Sac => (Config::sac(), None, None),
        }
    }
}

fn main() -> anyhow::Result<()> {
    let Cli { args, method } = Cli::parse();

    // The plan: the options over the defaults, or with --resume what the run's folder holds.
    let method = method.to_possible_value().map(|method| method.get_name().to_owned());
    let mut plan = args.plan(Plan { method, task: "b/hopper".to_owned(), ..Plan::new("sac_lagrangian") })?;

    // The settings: the method's preset, and the options over it.
    let (preset, separate, own) = Method::from_str(plan.method(), false).map_err(anyhow::Error::msg)?.parts();
    let config = args.settings(preset)?;
    plan.run.discount = config.discount;
    if let (Some(own), Some(given)) = (&own, &args.projection) {
        anyhow::bail!("--projection {given}: wanted none, for --method {} has its own, {}", plan.method(), own.name());
    }
    let projection = own.map_or_else(|| projection::by_name(&plan.projection), Ok)?;
    plan.projection = projection.name().to_owned();

    // The world, one of whose objectives is a cost with a limit.
    let env = make_env(&plan)?;
    let (spec, seed, mut rng) = (env.spec().clone(), plan.run.seed, Rng::new(plan.run.seed, Stream::Init));
    warn_of_limits(&spec, &config);

    // A stochastic actor, and critics: scalar ones for cost and for reward, or some that value both together.
    let (networks, threads) = (&config.networks, plan.threads);
    let actor = copq_candle::actor_for(&config, &spec, threads, &mut rng)?;
    let critic: Box<dyn Critic> = match separate {
        Some(counts) => Box::new(copq_candle::cost_and_reward_critics(&spec, counts, networks, threads, &mut rng)?),
        None => copq_candle::critics_for(projection.as_ref(), &spec, networks, threads, &mut rng)?,
    };

    // The learner, whose policy maximises the projected bound. A task without a cost is an error here.
    let learner = Learner::new(config.clone(), &spec, critic, actor, seed)?.projection(projection);

    // Train, and leave everything in a folder.
    let folder = args.open(&plan, &config)?;
    let trainer = Trainer::new(env, Box::new(learner), seed)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}
