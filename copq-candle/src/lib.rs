//! Critic ensembles and actors for copq on candle: seeded, saveable, fast on CPUs.
//!
//! A [`copq::Learner`] gets its networks from [`Candle`]:
//!
//! ```
//! use copq::{Agent, EnvSpec, Learner, Method, Mode};
//! use copq_candle::Candle;
//!
//! let spec = EnvSpec::new("example", 11, 3).reward("safety", 1.0).reward("velocity", 1.0);
//! let mut learner = Learner::new(Method::cop_td3(), &spec, &Candle::default(), 0)?;
//!
//! let mut action = [0.0; 3];
//! learner.act(&[0.1; 11], Mode::Exploit, &mut action)?;
//! assert!(action.iter().all(|a| a.abs() <= 1.0));
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! The networks can also be used on their own, with slices:
//!
//! ```
//! use copq::{Critic, EnvSpec, Net, Networks, Rng, Stream};
//!
//! let spec = EnvSpec::new("example", 11, 3)
//!     .reward("safety", 1.0)
//!     .reward("velocity", 1.0)
//!     .reward("control", 1.0);
//! let mut rng = Rng::new(0, Stream::Init);
//! let mut critic = copq_candle::fused::Critics::new(&spec, 4, &Networks::default(), &mut rng)?;
//!
//! let mut q = [0.0; 4 * 1 * 3]; // critics x rows x objectives
//! critic.values(Net::Online, &[0.1; 11], &[0.5; 3], &mut q)?;
//! # Ok::<(), copq::Error>(())
//! ```
//!
//! There are two implementations of each off-policy method's network, with the same initial weights
//! and the same saved state. [`fused`] is hand-written passes around matrix products for CPUs;
//! [`Candle`] makes these networks. [`plain`] is candle-nn's modules and autograd on any
//! [`Device`]. It is easy to read, and the fused one must equal it. On-policy methods' networks
//! have only the fused implementation.
//!
//! For your own architectures, as candle-nn modules, use [`Modules`].

#![deny(unsafe_code)]

mod adam;
mod check;
mod deviations;
pub mod fused;
mod init;
mod learned;
mod modules;
pub mod plain;
mod shape;
mod squash;

pub use candle_core::{self, Device};
pub use candle_nn;
use copq::{Actor, ActorKind, Backend, Critic, EnvSpec, Networks, Result, Rng, on_policy};
pub use modules::{MakeModule, Modules};

/// The networks of a [`copq::Learner`], in the fast implementation.
///
/// ```
/// use copq::{Agent, EnvSpec, Learner, Method};
/// use copq_candle::Candle;
///
/// let spec = EnvSpec::new("example", 11, 3).reward("safety", 1.0);
/// // Two threads for one learner; the results are the same, bit for bit.
/// let mut q = [[0.0], [0.0]];
/// for (backend, q) in [Candle::threads(1), Candle::threads(2)].iter().zip(&mut q) {
///     let mut learner = Learner::new(Method::td3(), &spec, backend, 0)?;
///     learner.value(&[0.1; 11], &[0.5; 3], q)?;
/// }
/// assert_eq!(q[0], q[1]);
/// # Ok::<(), copq::Error>(())
/// ```
///
/// The same backend reads a learned policy back:
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("policy.safetensors");
/// use copq::{Agent, EnvSpec, Learner, Method, Mode, Policy};
/// use copq_candle::Candle;
///
/// let spec = EnvSpec::new("example", 11, 3).reward("safety", 1.0);
/// let mut learner = Learner::new(Method::td3(), &spec, &Candle::default(), 0)?;
/// learner.save_policy(&path)?;
/// let mut policy = Policy::read(&path, &Candle::default())?;
///
/// let mut learned = [0.0; 3];
/// let mut read = [0.0; 3];
/// learner.act(&[0.1; 11], Mode::Exploit, &mut learned)?;
/// policy.act(&[0.1; 11], &mut read)?;
/// assert_eq!(learned, read);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Candle {
    threads: usize,
}

impl Default for Candle {
    /// One thread: several runs side by side are the best use of several cores.
    fn default() -> Self {
        Self::threads(1)
    }
}

impl Candle {
    /// A backend that spreads critics and actors of off-policy methods over this many threads,
    /// except an actor's bf16 products with the processor's own instruction. Those of on-policy
    /// methods are too small for it, and stay on one thread.
    pub fn threads(threads: usize) -> Self {
        Self { threads }
    }
}

impl Backend for Candle {
    fn critics(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>> {
        Ok(Box::new(fused::Critics::new(spec, count, networks, rng)?.threads(self.threads)?))
    }

    fn actor(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        rng: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        Ok(match kind {
            ActorKind::Deterministic => {
                Box::new(fused::Deterministic::new(spec, networks, rng)?.threads(self.threads)?)
            }
            ActorKind::Gaussian => {
                Box::new(fused::Gaussian::new(spec, networks, rng)?.threads(self.threads)?)
            }
            ActorKind::Normal => Box::new(fused::Normal::new(spec, networks, rng)?),
        })
    }

    fn policy(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
    ) -> Result<Box<dyn on_policy::GaussianPolicy>> {
        Ok(Box::new(fused::Normal::new(spec, networks, rng)?))
    }

    fn value(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
    ) -> Result<Box<dyn on_policy::StateValue>> {
        Ok(Box::new(fused::Value::new(spec, networks, rng)?))
    }
}
