//! Safe first, fast second: deep Q-learning with a *vector* of values, in priority order.
//!
//! An ensemble of K critics gives K guesses at the N values of an action (safety, speed, effort). copq turns their
//! disagreement into one confidence bound for the whole vector: it factors the critics' covariance in priority order,
//! so that each objective's bound is conditioned only on those above it. The lower bound goes into TD targets and the
//! actor, the upper one explores. That is COP-Q; the other ways to be pessimistic (eigenvectors, extreme points,
//! standard deviations, double-Q minima) are here too, behind one trait, [`Projection`].
//!
//! ```
//! use copq::projection::{Bound, Cholesky, Projection, QView, Scratch};
//!
//! // Three critics, one row, two objectives in priority order: safety, then speed.
//! let q = [10.0, 5.0,  12.0, 4.0,  11.0, 9.0];
//! let q = QView::new(&q, 3, 2)?;
//! let (mut scratch, mut low) = (Scratch::default(), [0.0; 2]);
//!
//! // A step of -1 is the lower bound of the TD target.
//! Cholesky.project(Bound { q, weights: &[1.0, 1.0], step: -1.0 }, &mut scratch, &mut low)?;
//! assert!((low[0] - 10.422650).abs() < 1e-5 && (low[1] - 4.788675).abs() < 1e-5);
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! The primary type is [`Learner`]: one off-policy update whose parts are values. Networks come from a backend that
//! implements [`Critic`] and [`Actor`] (`copq-candle`), worlds implement [`Env`] (`copq-envs-rapier`), and a [`Trainer`]
//! puts them together. This crate itself depends on no tensor library and no physics engine.
//!
//! # Cookbook
//!
//! **Swap the projection**, in one line:
//!
//! ```ignore
//! let learner = Learner::new(Config::cop_td3(), env.spec(), critic, actor, seed)?.projection(Extremum);
//! ```
//!
//! **Write a projection of your own**: implement [`Projection`] (a value and a vector-Jacobian product), or, if it is an
//! offset from the mean, only [`projection::Ellipsoid`].
//!
//! **Write an environment of your own**: implement [`Env`], and run [`check_env`] on it before anything else.
//!
//! **Choose a method**: [`Config::cop_td3`], [`Config::sac`] and their relatives are presets of the one learner, and
//! [`Config`]'s table says which critics and projection each is meant for.
//!
//! **Explore otherwise**: a policy's own noise explores unless [`Config::optimism`] says how far its actions move towards the
//! critics' upper bound ([`Config::cop_td3_oac`]); [`Optimism::projection`] names whose. `learner.explore(...)` takes a rule of
//! your own.
//!
//! **Change the priorities**: `OrderedEnv::new(env, &["velocity", "safety", "control"])` is the same world in another order.
//!
//! **Train, save, resume**: [`Trainer::step`] is one environment step with its learning, [`Trainer::save`] holds everything;
//! a loaded trainer goes on bit for bit.
//!
//! **See why a run fails**: give [`Trainer::step`] an [`Observer`]; the learner reports values, targets, losses, the critics'
//! spread, how often the clip fires, and FAMO's weights, all by objective.

mod actor;
mod adam;
mod agent;
mod check_env;
mod config;
mod critic;
mod env;
pub mod error;
mod explore;
mod famo;
mod learner;
mod loss;
mod multiplier;
mod normaliser;
mod observer;
mod ordered;
mod policy;
pub mod projection;
mod replay;
mod rng;
mod separate;
mod state;
mod temperature;
mod trainer;

pub use actor::{ActionGrad, Actor, Sample, SampleGrad};
pub use agent::{Agent, Mode, Transition};
pub use check_env::{EnvReport, check_env};
pub use config::{Activation, Config, Init, Networks, Optimism, Smoothing, WarmUp};
pub use critic::{Critic, Net, QGrad};
pub use env::{Env, EnvSpec, Outcome};
pub use error::{Error, Result};
pub use explore::{Context, Explore, GaussianNoise, Optimistic, PolicySamples, UniformActions};
pub use famo::{Famo, FamoConfig, FamoDecay};
pub use learner::Learner;
pub use multiplier::{
    Constraint, FixedWeights, Lagrangian, LagrangianConfig, Multiplier, Pid, PidConfig, discounted_limit,
};
pub use normaliser::Normaliser;
pub use observer::{Observer, Silent};
pub use ordered::OrderedEnv;
pub use policy::Policy;
pub use projection::{Bound, Projection, QView, Scratch};
pub use replay::{Batch, Replay};
pub use rng::{Rng, Stream};
pub use separate::SeparateCritics;
pub use state::{Element, State, Value};
pub use temperature::Entropy;
pub use trainer::{Episode, Evaluation, Timing, Trainer, evaluate};
