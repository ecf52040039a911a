//! Critic ensembles and actors for copq on candle: seeded, saveable, fast on CPUs.
//!
//! ```
//! use copq::{Critic, EnvSpec, Net, Networks, Rng, Stream};
//!
//! let spec = EnvSpec {
//!     name: "example".into(),
//!     observation: 11,
//!     action_low: vec![-1.0; 3],
//!     action_high: vec![1.0; 3],
//!     objectives: vec!["safety".into(), "velocity".into(), "control".into()],
//!     weights: vec![1.0; 3],
//!     limits: vec![],
//!     entropy: None,
//!     horizon: 1000,
//! };
//! let mut rng = Rng::new(0, Stream::Init);
//! let mut critic = copq_candle::critic(&spec, 4, &Networks::default(), &mut rng)?;
//! let mut actor = copq_candle::actor(&spec, &Networks::default(), &mut rng)?;
//!
//! let mut q = [0.0; 4 * 1 * 3];
//! critic.values(Net::Online, &[0.1; 11], &[0.5; 3], &mut q)?;
//! # let _ = &mut actor;
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! There are two implementations of each network, with the same initial weights and the same saved state:
//! [`fused`], hand-written passes around matrix products for CPUs, which [`critic`] and [`actor`] return; and [`plain`],
//! candle's tensors and autograd on any [`Device`], which is easy to read and is what the fused one must equal.

#![deny(unsafe_code)]

mod adam;
mod check;
pub mod fused;
mod init;
mod learned;
pub mod plain;
mod shape;
mod squash;
mod weights;

pub use candle_core::Device;
use copq::{Actor, Config, Critic, EnvSpec, Networks, Projection, Result, Rng, SeparateCritics};

/// K critics for an environment, in the fast implementation, with fresh weights from `rng` ([`copq::Stream::Init`]).
pub fn critic(spec: &EnvSpec, critics: usize, networks: &Networks, rng: &mut Rng) -> Result<fused::Critics> {
    fused::Critics::new(spec, critics, networks, rng)
}

/// The critics that a projection is meant for: as many as it says, together or separate for each objective.
pub fn critics_for(
    projection: &dyn Projection,
    spec: &EnvSpec,
    networks: &Networks,
    threads: usize,
    rng: &mut Rng,
) -> Result<Box<dyn Critic>> {
    let objectives = spec.objectives.len();
    let critics = projection.critics(objectives);
    Ok(if projection.separate() {
        Box::new(separate_critics(spec, &vec![critics; objectives], networks, threads, rng)?)
    } else {
        Box::new(critic(spec, critics, networks, rng)?.threads(threads)?)
    })
}

/// A deterministic actor for an environment, in the fast implementation, with fresh weights from `rng`.
pub fn actor(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<fused::Deterministic> {
    fused::Deterministic::new(spec, networks, rng)
}

/// A squashed Gaussian actor (SAC) for an environment, in the fast implementation, with fresh weights from `rng`.
pub fn gaussian_actor(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<fused::Gaussian> {
    fused::Gaussian::new(spec, networks, rng)
}

/// The actor that a method is meant for: a squashed Gaussian if it has an entropy bonus, else a deterministic one.
pub fn actor_for(config: &Config, spec: &EnvSpec, threads: usize, rng: &mut Rng) -> Result<Box<dyn Actor>> {
    Ok(match config.entropy {
        None => Box::new(actor(spec, &config.networks, rng)?.threads(threads)?),
        Some(_) => Box::new(gaussian_actor(spec, &config.networks, rng)?.threads(threads)?),
    })
}

/// Separate scalar critics, as many for each cost and for each reward as is said: 4 and 2 for CAL, wherever the cost
/// stands among the objectives.
pub fn cost_and_reward_critics(
    spec: &EnvSpec,
    [of_cost, of_reward]: [usize; 2],
    networks: &Networks,
    threads: usize,
    rng: &mut Rng,
) -> Result<SeparateCritics> {
    let count = |i| if spec.limit(i).is_some() { of_cost } else { of_reward };
    let counts: Vec<usize> = (0..spec.objectives.len()).map(count).collect();
    separate_critics(spec, &counts, networks, threads, rng)
}

/// Separate scalar critics for each objective, `counts[i]` of them for objective i, in the fast implementation: such as
/// pairs (independent double-Q). See [`fused::Critics::threads`].
pub fn separate_critics(
    spec: &EnvSpec,
    counts: &[usize],
    networks: &Networks,
    threads: usize,
    rng: &mut Rng,
) -> Result<SeparateCritics> {
    let scalar = EnvSpec {
        objectives: vec!["value".to_owned()],
        weights: vec![1.0],
        limits: vec![],
        entropy: None,
        ..spec.clone()
    };
    SeparateCritics::new(Box::new(critic(&scalar, counts.iter().sum(), networks, rng)?.threads(threads)?), counts)
}
