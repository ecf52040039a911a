//! COP-Q on TD3: a robot learns to be safe first, fast second, frugal third.
//!
//! `cargo run --release --example td3` trains the hopper on rapier; `--help` explains the rest.

use clap::{Parser, ValueEnum};
use copq::{Config, Learner, Projection, Rng, Stream, Trainer, projection};
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

    /// What is learned and how it explores. With --resume it is the run's.
    ///
    /// With cop-td3-oac, --set optimism.projection=extremum explores towards another upper bound than --projection's.
    #[arg(long, value_enum, default_value = "cop-td3", conflicts_with = "resume")]
    method: Method,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Method {
    /// COP-Q: a vector of values whose common bound is cautious.
    CopTd3,
    /// COP-Q that explores towards the critics' upper bound (COP-OAC).
    CopTd3Oac,
    /// COP-Q in the protocol of the paper's main comparison, for reproduction: a million steps of the paper's robots.
    CopTd3Paper,
    /// TD3 as its authors have it: for tasks with one objective, such as --task gym/hopper.
    Td3,
}

impl Method {
    fn config(self, projection: &dyn Projection) -> Config {
        match self {
            Self::CopTd3 => Config::cop_td3().for_projection(projection),
            Self::CopTd3Oac => Config::cop_td3_oac().for_projection(projection),
            Self::CopTd3Paper => Config::cop_td3_paper(),
            Self::Td3 => Config::td3(),
        }
    }

    fn plan(self) -> Plan {
        let mut plan = Plan::new("td3");
        plan.method = self.to_possible_value().map(|name| name.get_name().to_owned());
        if self == Self::CopTd3Paper {
            plan.preset = "paper".to_owned();
            plan.run.steps = 1_000_000;
        }
        plan
    }
}

fn main() -> anyhow::Result<()> {
    let Cli { args, method } = Cli::parse();

    // The settings: the method's preset, the options over it, or with --resume what the run's folder holds.
    let mut plan = args.plan(method.plan())?;
    let projection = projection::by_name(&plan.projection)?;
    let config = args.settings(method.config(&projection))?;
    plan.run.discount = config.discount;
    if args.resume.is_none() && (method == Method::CopTd3Oac) != config.optimism.is_some() {
        anyhow::bail!("--set optimism: wanted --method cop-td3-oac beside it, and with that method no optimism=none");
    }

    // The world, twice: to learn in, and to be evaluated in.
    let env = make_env(&plan)?;
    let spec = env.spec().clone();
    warn_of_limits(&spec, &config);
    if method == Method::Td3 && spec.objectives.len() > 1 {
        anyhow::bail!("--method td3: wanted a task with one objective, such as --task gym/hopper, got {}", spec.name);
    }

    // The networks: the critics that the projection wants, N + 1 of N values each for Cholesky, and a deterministic actor.
    let mut rng = Rng::new(plan.run.seed, Stream::Init);
    let critic = copq_candle::critics_for(projection.as_ref(), &spec, &config.networks, plan.threads, &mut rng)?;
    let actor = copq_candle::actor_for(&config, &spec, plan.threads, &mut rng)?;

    // The learner. Swapping the projection is this one line.
    let learner = Learner::new(config.clone(), &spec, critic, actor, plan.run.seed)?;
    let learner = learner.projection(projection);

    // Train, and leave everything in a folder.
    let folder = args.open(&plan, &config)?;
    let trainer = Trainer::new(env, Box::new(learner), plan.run.seed)?;
    println!("{}", Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?);
    Ok(())
}
