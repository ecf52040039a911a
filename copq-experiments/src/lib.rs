//! What a training run leaves behind: a folder with its configuration, metrics, checkpoint and
//! figures.
//!
//! [`Run`] is the primary type: it drives a [`copq::Trainer`], evaluates, logs, saves, and resumes
//! after any stop as if there had been none (except in an environment that cannot be saved, after
//! an error of its environment, and from a checkpoint without its replay).
//!
//! ```no_run
//! use copq::{Agent, Env, Method, Result, Trainer};
//! use copq_experiments::{Plan, Run, RunFolder};
//!
//! fn train(
//!     make_env: fn() -> Result<Box<dyn Env>>,
//!     make_agent: fn(Method) -> Result<Box<dyn Agent>>,
//! ) -> Result<()> {
//!     let method = Method::cop_td3();
//!     let env = make_env()?;
//!     // A plan's words are yours to choose: nothing compares them with the trainer.
//!     let plan = Plan { task: env.spec().name.clone(), ..Plan::new(&method) };
//!     let config = method.config.clone();
//!     let folder = RunFolder::create("runs/first", &plan, &config)?; // with its config.toml
//!     let trainer = Trainer::new(env, make_agent(method)?)?;
//!     let ending = Run::new(trainer, Some(make_env()?), folder, plan.run)?.train()?;
//!     println!("{ending}"); // where everything is, or how to resume after Ctrl-C
//!     Ok(())
//! }
//! ```
//!
//! The files are described at [`RunFolder`]. [`compare`] draws several runs in one picture.
//! [`Report`] puts thousands on one page, with tables and [`statistics`], beside the numbers and
//! claims of a [`paper`]. [`Sheet`] reads the CSV files, and [`read_checkpoint`] the checkpoints.
//! [`Standing`] says how far a run has come, and [`fingerprint`](fingerprint()) whether two are the
//! same.

mod aside;
mod best;
mod checkpoints;
mod config;
mod ending;
mod evaluations;
mod figure;
mod fingerprint;
mod folder;
mod lock;
mod metrics;
mod numbers;
mod older;
mod onnx;
mod origin;
mod plan;
mod progress;
mod records;
mod report;
mod run;
mod settings;
mod sheet;
mod standing;
pub mod statistics;
mod stop;
mod table;
mod tensorboard;
mod timings;

pub use checkpoints::{checkpoint_files, read_checkpoint};
pub use config::{MadeWith, RunConfig, with_changes};
pub use ending::{Ending, quoted};
pub use figure::{compare, comparison_table};
pub use fingerprint::{fingerprint, letters_of, policy_checksum};
pub use folder::{RunFolder, read_config, read_done, read_plan};
pub use lock::held_by;
pub use onnx::{read_policy, write_onnx};
pub use plan::Plan;
pub use report::{Cell, Report, ReportRun, Table, paper};
pub use run::Run;
pub use settings::{OnEnvError, OnResume, RunSettings, SavedReplay};
pub use sheet::Sheet;
pub use standing::{Standing, complaint_file, failure, steps_done};
pub use stop::Stop;
