//! SAC under a constraint: run as fast as a speed limit allows.
//!
//! `cargo run --release --example sac_lagrangian` trains the hopper of benchmark B on rapier; `--help` explains the rest.

use clap::{Parser, ValueEnum};
use copq::projection::{Conservative, IndependentMin};
use copq::{Config, Constraint, Critic, Learner, PidConfig, Projection, Rng, Stream, Trainer, projection};
use copq_examples::make_env;
use copq_experiments::{Args, Plan, Run};

/// Trains SAC with a multiplier that holds the task's cost below its limit.
#[derive(Parser)]
#[command(name = "sac_lagrangian")]
struct Cli {
    #[command(flatten)]
    args: Args,

    /// Who values cost and reward, how cautiously, and who sets the multiplier. [default: cop-cal]
    #[arg(long, value_enum, conflicts_with = "resume")]
    method: Option<Method>,

    /// Environment steps with uniformly random actions before learning begins. [default: the method's]
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    start_steps: Option<u64>,
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
}

/// A method's settings, its critics of cost and of reward if they are separate, and its projection if it has no choice.
type Parts = (Config, Option<[usize; 2]>, Option<Box<dyn Projection>>);

impl Method {
    fn parts(self) -> Parts {
        let pid = Some(Constraint::Pid(PidConfig::default()));
        match self {
            Self::CopCal => (Config::cop_cal(), None, None),
            Self::Cal => (Config::cal(), Some([4, 2]), Some(Box::new(Conservative::cal(0.5, 4)))),
            Self::CalOriginal => (Config::cal_original(), Some([4, 2]), Some(Box::new(Conservative::cal(0.5, 4)))),
            Self::SaclagUcb => (Config::sac_lagrangian(), Some([2, 2]), Some(Box::new(IndependentMin))),
            Self::SacLagrangian => (Config::sac_lagrangian(), Some([1, 2]), Some(Box::new(IndependentMin))),
            Self::SacPid => (Config { constraint: pid, ..Config::sac() }, Some([1, 2]), Some(Box::new(IndependentMin))),
        }
    }
}

fn main() -> anyhow::Result<()> {
    let Cli { args, method, start_steps } = Cli::parse();

    // The plan: the options over the defaults, or with --resume what the run's folder holds.
    let value = method.unwrap_or(Method::CopCal).to_possible_value();
    let method = value.map(|value| value.get_name().to_owned());
    let mut plan = args.plan(Plan { method, task: "b/hopper".to_owned(), ..Plan::new("sac_lagrangian") })?;

    // The settings: the method's preset, and the options over it.
    let (preset, separate, own) = Method::from_str(plan.method(), false).map_err(anyhow::Error::msg)?.parts();
    let start_steps = start_steps.unwrap_or(preset.start_steps);
    let config = args.settings(Config { start_steps, ..preset })?;
    plan.run.discount = config.discount;
    if let (Some(own), Some(given)) = (&own, &args.projection) {
        anyhow::bail!("--projection {given}: wanted none, for --method {} has its own, {}", plan.method(), own.name());
    }
    let projection = own.map_or_else(|| projection::by_name(&plan.projection), Ok)?;
    plan.projection = projection.name().to_owned();

    // The world, whose first objective is a cost with a limit, and a stochastic actor.
    let env = make_env(&plan)?;
    let (spec, seed, mut rng) = (env.spec().clone(), plan.run.seed, Rng::new(plan.run.seed, Stream::Init));
    let actor = Box::new(copq_candle::gaussian_actor(&spec, &config.networks, &mut rng)?.threads(plan.threads)?);

    // The critics: scalar ones for cost and for reward, or some that value both together.
    let (networks, threads, together) = (&config.networks, plan.threads, projection.critics(spec.objectives.len()));
    let critic: Box<dyn Critic> = match separate {
        Some(counts) => Box::new(copq_candle::separate_critics(&spec, &counts, networks, threads, &mut rng)?),
        None => Box::new(copq_candle::critic(&spec, together, networks, &mut rng)?.threads(threads)?),
    };

    // The learner, whose policy maximises the projected bound. A task without a cost is an error here.
    let learner = Learner::new(config.clone(), &spec, critic, actor, seed)?.projection(projection);

    // Train, and leave everything in a folder.
    let folder = args.open(&plan, &config)?;
    let trainer = Trainer::new(env, Box::new(learner), seed)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}
