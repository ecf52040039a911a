//! Safe first, fast second: deep Q-learning with a *vector* of values, in priority order.
//!
//! An ensemble of K critics gives K guesses at the N values of an action (safety, speed, effort).
//! copq turns their disagreement into one confidence bound for the whole vector: it factors the
//! critics' covariance in priority order, so that each objective's bound is conditioned only on
//! those above it (but where a clip keeps the total from rising). The lower bound goes into TD
//! targets and the actor, the upper one can explore. That is COP-Q; the other ways to be pessimistic
//! (eigenvectors, extreme points, standard deviations, double-Q minima) are here too, behind one
//! trait, [`Projection`].
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
//! | learn from the policy's own steps alone (PPO and its constrained kin) | [`on_policy`] |
//! | learn by it | [`Learner`], with networks from a [`Backend`] (`copq_candle::Candle`) |
//! | describe a world | [`Env`] and its [`EnvSpec`]; [`check_env`] first of all (robots: `copq-envs-rapier`, `copq-envs-mujoco`) |
//! | train, evaluate, save, resume | [`Trainer`], or run folders with `copq-experiments` |
//! | use what was learned | [`Policy`] |
//! | bound the critics your own way | [`projection::Ellipsoid`], or [`Projection`] written out |
//! | explore, or weigh costs, your own way | [`Explore`], [`Multiplier`] |
//! | bring your own networks | [`Critic`], [`Actor`], or a whole [`Backend`] |
//!
//! Observations are flat vectors of `f32`, actions boxes of continuous numbers: there are no
//! discrete actions and no images. Off-policy methods learn from one environment at a time. This
//! crate itself depends on no tensor library and no physics engine; `copq_candle::Candle` computes
//! on the CPU.
//!
//! ```ignore
//! let env = copq_envs_rapier::make("a/hopper")?;
//! let method = Method::cop_td3().bound(Extremum); // the swap: critics follow
//! let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
//! let mut trainer = Trainer::new(env, learner)?;
//! trainer.run(20_000, &mut Silent)?; // a beginning: a hopper stands after some 110,000
//! println!("{}", trainer.evaluate(10)?);
//! ```
//!
//! # Cookbook
//!
//! **Explore otherwise**: by default the policy's own noise explores. [`Method::explore`] shifts its
//! actions towards the critics' upper bound ([`Method::cop_td3_oac`]), by the projection that
//! [`Optimism::projection`] names. [`Learner::explore`] takes a rule of your own.
//!
//! **Change the priorities**: [`AdjustedEnv`] is the same world with its objectives in another
//! order, with other weights, and other limits of its costs.
//!
//! **Train, save, resume**: [`Trainer::step`] is one environment step with its learning,
//! [`Trainer::save`] holds everything; a loaded trainer goes on bit for bit, and refuses what is of
//! another method, task or seed.
//!
//! **See why a run fails**: give [`Trainer::step`] an [`Observer`]; the learner reports values,
//! targets, losses, the critics' spread, how often the clip fires, and FAMO's weights, all by
//! objective.
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | objective | one component of the reward vector: a reward, or a cost |
//! | cost, limit | an objective to keep small, told as a number of 0 or more; the most that its sum over an episode may be |
//! | priority | the objectives' order, most important first |
//! | critics, ensemble | networks of all N values, or *separate* ones of one value each; all of them together |
//! | projection, bound | a rule that makes one vector of what the critics say of an action; that vector. Its *step* is signed: -1 is the lower (pessimistic) bound, 1 the upper one |
//! | clip | the turn R that keeps a Cholesky lower bound from raising the weighted total |
//! | weights | the scalarisation w, not a network's parameters; u = w / \|w\| is their direction |
//! | target network | the slow copy of a network |
//! | TD target | the value that critics learn towards |
//! | FAMO | learned weights of the objectives' losses, so that their logarithms fall equally fast |
//! | agent, learner, trainer | what acts and may learn; an agent that learns, off-policy or on; an agent with its world, step by step |
//! | mode | a policy's action without noise |
//! | Sigma, L | the critics' covariance of one action's values; its Cholesky factor, in priority order |

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
