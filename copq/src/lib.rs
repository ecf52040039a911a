//! Safe first, fast second: deep Q-learning with a *vector* of values, in priority order.
//!
//! An ensemble of K critics gives K estimates of the N values of an action (safety, speed, effort).
//! copq turns their disagreement into one confidence bound for the whole vector. It factors the
//! critics' covariance in priority order, so each objective's bound is conditioned only on those
//! above it (except where a clip keeps the total from rising). The lower bound goes into the TD
//! targets and the actor; the upper bound can drive exploration. That is COP-Q. The other ways to
//! be pessimistic (eigenvectors, extreme points, standard deviations, double-Q minima) are here
//! too, behind one trait, [`Projection`].
//!
//! ```
//! use copq::projection::{BoundQuery, Cholesky, Projection, QView, Scratch};
//!
//! // Three critics, one row, two objectives in priority order: safety, then speed.
//! let q = [10.0, 5.0,  12.0, 4.0,  11.0, 9.0];
//! let q = QView::new(&q, 3, 2)?;
//! let mut scratch = Scratch::default();
//! let mut low = [0.0; 2];
//!
//! // A step of -1 is the lower bound of the TD target.
//! Cholesky.project(BoundQuery { q, weights: &[1.0, 1.0], step: -1.0 }, &mut scratch, &mut low)?;
//! assert!((low[0] - 10.422650).abs() < 1e-5 && (low[1] - 4.788675).abs() < 1e-5);
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! # Which type do I need?
//!
//! | you want to | type |
//! |---|---|
//! | choose or compose an algorithm | [`Method`], with its numbers in [`Config`] and its critics in [`Ensemble`] |
//! | learn only from the policy's own steps (PPO and its constrained variants) | [`on_policy`] |
//! | learn with it | [`Learner`], with networks from a [`Backend`] (`copq_candle::Candle`) |
//! | describe an environment | [`Env`] and its [`EnvSpec`]; call [`check_env`] first (robots: `copq-envs-rapier`, `copq-envs-mujoco`) |
//! | train, evaluate, save, resume | [`Trainer`], or run folders with `copq-experiments` |
//! | use a learned policy | [`Policy`] |
//! | bound the critics your own way | [`projection::Ellipsoid`], or a [`Projection`] written out in full |
//! | explore, or weight costs, your own way | [`Explore`], [`Multiplier`] |
//! | bring your own networks | [`Critic`], [`Actor`], or a whole [`Backend`] |
//!
//! Observations are flat vectors of `f32`, and actions are boxes of continuous numbers: there are
//! no discrete actions and no images. Off-policy methods learn from one environment at a time. This
//! crate itself does not depend on a tensor library or a physics engine; `copq_candle::Candle`
//! computes on the CPU.
//!
//! ```ignore
//! let env = copq_envs_rapier::make("a/hopper")?;
//! let method = Method::cop_td3().bound(Extremum); // the swap; the critics follow
//! let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
//! let mut trainer = Trainer::new(env, learner)?;
//! trainer.run(20_000, &mut Silent)?; // only a start: a hopper stands after about 110,000
//! println!("{}", trainer.evaluate(10)?);
//! ```
//!
//! # Cookbook
//!
//! **Explore differently**: by default, the policy's own noise explores. [`Method::explore`] shifts
//! the actions towards the critics' upper bound ([`Method::cop_td3_oac`]), under the projection
//! that [`Optimism::projection`] names. [`Learner::explore`] takes your own rule.
//!
//! **Change the priorities**: [`AdjustedEnv`] wraps an environment to change the order and the
//! weights of its objectives and the limits of its costs.
//!
//! **Train, save, resume**: [`Trainer::step`] is one environment step with its learning.
//! [`Trainer::save`] saves everything. A loaded trainer resumes bit for bit, and refuses the state
//! of a different method, task or seed.
//!
//! **See why a run fails**: give [`Trainer::step`] an [`Observer`]. For each objective, the learner
//! reports values, targets, losses, the critics' spread and FAMO's weights; it also reports how
//! often the clip fires.
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | objective | one component of the reward vector: a reward or a cost |
//! | cost, limit | an objective to keep small, reported as a number of 0 or more; the limit is the largest sum over an episode that is allowed |
//! | priority | the order of the objectives, most important first |
//! | critics, ensemble | networks that each estimate all N values, or *separate* ones that estimate one value each; the ensemble is all of them together |
//! | projection, bound | a rule that turns the critics' estimates for an action into one vector; the bound is that vector. Its *step* is signed: -1 is the lower (pessimistic) bound, 1 the upper one |
//! | clip | the rotation R that keeps a Cholesky lower bound from raising the weighted total |
//! | weights | the scalarisation weights w, not a network's parameters; u = w / \|w\| is their direction |
//! | target network | a copy of a network that follows it slowly |
//! | TD target | the value that critics are trained towards |
//! | FAMO | learned weights for the objectives' losses, so that the logarithms of the losses fall equally fast |
//! | agent, learner, trainer | an agent acts and may learn; a learner is an agent that learns, off-policy or on-policy; a trainer runs an agent in its environment, step by step |
//! | mode | a policy's action without noise |
//! | Sigma, L | the covariance of the critics' values for one action; its Cholesky factor, in priority order |

mod actor;
mod adam;
mod adjusted;
mod agent;
mod backend;
mod batch;
mod check_env;
mod checkpoint;
mod coverage;
mod critic;
mod env;
pub mod error;
mod evaluation;
mod explore;
mod famo;
pub mod files;
mod learner;
mod loss;
mod made_by;
mod memory;
mod method;
mod multiplier;
mod normaliser;
mod observer;
pub mod on_policy;
mod policy;
pub mod projection;
mod replay;
mod rng;
mod rollout;
mod separate;
mod spec;
mod state;
mod temperature;
mod timing;
mod trainer;

pub use actor::{ActionGrad, Actor, Sample, SampleGrad};
pub use adjusted::{AdjustedEnv, read_weights};
pub use agent::{Agent, Mode, Transition};
pub use backend::{ActorKind, Backend};
pub use batch::Batch;
pub use check_env::{EnvReport, check_env};
pub use coverage::{Coverage, CoverageConfig, ObjectiveCoverage, coverage};
pub use critic::{Critic, Net, QGrad};
pub use env::{Env, Outcome};
pub use error::{Error, Result};
pub use evaluation::{Evaluation, evaluate, evaluate_while};
pub use explore::{Context, Explore, GaussianNoise, Optimistic, PolicySamples, UniformActions};
pub use famo::{Famo, FamoConfig, FamoDecay};
pub use learner::{Learner, QEstimate};
pub use method::{
    Activation, Config, Ensemble, Init, Method, Networks, Optimism, Precision, Smoothing, WarmUp,
};
pub use multiplier::{
    Constraint, FixedWeights, Lagrangian, LagrangianConfig, Multiplier, Pid, PidConfig,
    discounted_limit,
};
pub use normaliser::Normaliser;
pub use observer::{Observer, Silent};
pub use policy::Policy;
pub use projection::{BoundQuery, Projection, QView, Scratch};
pub use replay::Replay;
pub use rng::{Rng, Stream};
pub use rollout::{Episode, Rollout};
pub use separate::SeparateCritics;
pub use spec::{EnvSpec, Objective};
pub use state::{Element, State, Value};
pub use temperature::Entropy;
pub use timing::Timing;
pub use trainer::Trainer;
