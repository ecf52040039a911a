//! copq (skeleton docs; the pitch and cookbook are written with the learner).

mod actor;
mod agent;
mod check_env;
mod config;
mod critic;
mod env;
pub mod error;
mod explore;
mod famo;
// mod learner;
mod loss;
mod multiplier;
mod observer;
pub mod projection;
mod replay;
mod rng;
mod state;
mod trainer;

pub use actor::{ActionGrad, Actor, Sample, SampleGrad};
pub use agent::{Agent, Mode, Transition};
pub use check_env::{EnvReport, check_env};
pub use config::{Config, Networks, Smoothing};
pub use critic::{Critic, Net, QGrad};
pub use env::{Env, EnvSpec, Outcome};
pub use error::{Error, Result};
pub use explore::{Context, Explore, Gaussian, Uniform};
pub use famo::{Famo, FamoConfig};
// pub use learner::Learner;
pub use multiplier::{Fixed, Multiplier};
pub use observer::{Observer, Silent};
pub use projection::{Projection, QView, Scratch};
pub use replay::{Batch, Replay};
pub use rng::{Rng, Stream};
pub use state::{Element, State, Value};
pub use trainer::{Episode, Evaluation, Timing, Trainer, evaluate};
