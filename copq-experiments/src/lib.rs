//! What a training run leaves behind: a folder with its configuration, metrics, checkpoint and figures.
//!
//! [`Run`] is the primary type: it drives a [`copq::Trainer`], evaluates, logs, saves, and goes on after any stop as if
//! there had been none.
//!
//! ```no_run
//! use clap::Parser;
//! use copq::{Agent, Config, Env, Result, Trainer};
//! use copq_experiments::{Args, Plan, Run};
//!
//! /// Trains my agent.
//! #[derive(Parser)]
//! struct Cli {
//!     #[command(flatten)]
//!     args: Args,
//! }
//!
//! fn train(make_env: fn(&Plan) -> Result<Box<dyn Env>>, make_agent: fn(&Plan, &Config) -> Result<Box<dyn Agent>>) -> Result<()> {
//!     let args = Cli::parse().args;
//!     let mut plan = args.plan(Plan::new("td3"))?; // the options, or with --resume the saved plan
//!     let config = args.settings(Config::cop_td3())?; // likewise for the learner's settings
//!     plan.run.discount = config.discount;
//!     let folder = args.open(&plan, &config)?; // makes or reopens the folder, with its config.toml
//!     let trainer = Trainer::new(make_env(&plan)?, make_agent(&plan, &config)?, plan.run.seed)?;
//!     let ending = Run::new(trainer, make_env(&plan)?, folder, plan.run)?.train()?;
//!     println!("{ending}"); // where everything is, or how to go on after Ctrl-C
//!     Ok(())
//! }
//! ```
//!
//! The files are described at [`RunFolder`]. [`compare`] draws several runs in one picture, as does the program
//! `copq-plot`; [`Sheet`] reads the CSV files, [`checkpoint`] the checkpoints, and [`animation`] shows what has been learned.

pub mod animation;
mod args;
pub mod checkpoint;
mod config;
mod evaluations;
mod figure;
mod files;
mod folder;
mod metrics;
mod numbers;
mod plan;
mod progress;
mod run;
mod sheet;
pub mod statistics;
mod stop;
mod table;
pub mod tensorboard;
mod timings;

pub use args::Args;
pub use config::{MadeWith, RunConfig};
pub use figure::{Labelled, compare, comparison_table};
pub use folder::{RunFolder, read_checkpoint, read_config, read_plan};
pub use metrics::Metrics;
pub use numbers::Numbers;
pub use plan::{Plan, RunSettings};
pub use run::{Ending, Run};
pub use sheet::Sheet;
