//! SAC under a constraint: run as fast as a speed limit allows.
//!
//! `cargo run --release --example sac_lagrangian` trains the hopper of benchmark B on rapier; `--help` explains the rest.

use clap::{Parser, ValueEnum};
use copq::projection::Conservative;
use copq::{Config, Critic, Learner, Projection, Rng, Stream, Trainer, projection};
use copq_examples::make_env;
use copq_experiments::{Args, Plan, Run};

/// Trains SAC with a learned Lagrange multiplier that holds the task's cost below its limit.
#[derive(Parser)]
#[command(name = "sac_lagrangian")]
struct Cli {
    #[command(flatten)]
    args: Args,

    /// Who values cost and reward, and how cautiously. [default: cop-cal]
    #[arg(long, value_enum, conflicts_with = "resume")]
    method: Option<Method>,

    /// Environment steps with uniformly random actions before learning begins. [default: 10000]
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    start_steps: Option<u64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// COP-Q on CAL: three critics of cost and reward together, and the bound of --projection.
    CopCal,
    /// CAL: four cost critics, each with a target of its own, and two reward critics.
    Cal,
    /// SACLag-UCB: two cost critics, of which the larger counts, and two reward critics.
    SaclagUcb,
    /// SAC-Lagrangian: one cost critic and two reward critics.
    SacLagrangian,
}

impl Method {
    /// As the command line and config.toml spell it.
    fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// What a method is made of: its settings, its separate critics of cost and reward if they are separate, and
    /// whose bound it takes if it has no choice.
    fn parts(self) -> (Config, Option<[usize; 2]>, Option<Box<dyn Projection>>) {
        let lagrangian = Config::sac_lagrangian;
        match self {
            Self::CopCal => (Config::cop_cal(), None, None),
            Self::Cal => (Config::cal(), Some([4, 2]), Some(Box::new(Conservative::cal(0.5, 4)))),
            Self::SaclagUcb => (lagrangian(), Some([2, 2]), Some(Box::new(projection::IndependentMin))),
            Self::SacLagrangian => (lagrangian(), Some([1, 2]), Some(Box::new(projection::IndependentMin))),
        }
    }
}

fn main() -> anyhow::Result<()> {
    let Cli { args, method, start_steps } = Cli::parse();

    // The plan: the options over the defaults, or with --resume what the run's folder holds.
    let method = method.unwrap_or(Method::CopCal).name();
    let program = Plan { method, task: "b/hopper".to_owned(), ..Plan::new("sac_lagrangian") };
    let mut plan = args.plan(program)?;

    // The settings: the method's preset, and the options over it.
    let method = Method::from_str(&plan.method, false).map_err(anyhow::Error::msg)?;
    let (preset, separate, own) = method.parts();
    let start_steps = start_steps.unwrap_or(preset.start_steps);
    let config = args.settings(Config { start_steps, ..preset })?;
    plan.run.discount = config.discount;
    if let (Some(own), Some(given)) = (&own, &args.projection) {
        anyhow::bail!("--projection {given}: wanted none, for --method {} has its own, {}", plan.method, own.name());
    }
    let projection = own.map_or_else(|| projection::by_name(&plan.projection), Ok)?;
    plan.projection = projection.name().to_owned();

    // The world, whose first objective is a cost with a limit, and a stochastic actor.
    let env = make_env(&plan)?;
    let spec = env.spec().clone();
    let (seed, mut rng) = (plan.run.seed, Rng::new(plan.run.seed, Stream::Init));
    let actor = Box::new(copq_candle::gaussian_actor(&spec, &config.networks, &mut rng)?);

    // The critics: scalar ones for cost and for reward, or some that value both together.
    let critic: Box<dyn Critic> = match separate {
        Some(counts) => {
            Box::new(copq_candle::separate_critics(&spec, &counts, &config.networks, plan.threads, &mut rng)?)
        }
        None => {
            let critics = projection.critics(spec.objectives.len());
            Box::new(copq_candle::critic(&spec, critics, &config.networks, &mut rng)?.threads(plan.threads)?)
        }
    };

    // The learner. A task without a cost is an error here.
    let learner = Learner::new(config.clone(), &spec, critic, actor, seed)?.projection(projection);

    // Train, and leave everything in a folder.
    let folder = args.open(&plan, &config)?;
    let trainer = Trainer::new(env, Box::new(learner), seed)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}
