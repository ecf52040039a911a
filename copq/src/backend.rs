//! The interface to a tensor library, which builds the networks.

use crate::on_policy::{GaussianPolicy, StateValue};
use crate::{Actor, Critic, EnvSpec, Error, Networks, Result, Rng};

/// Builds the networks of a [`Learner`](crate::Learner): `copq_candle::Candle`, or your own.
///
/// A backend knows shapes, activations and step sizes ([`Networks`]), but no algorithm: the
/// [`Method`](crate::Method) decides how many critics there are and what happens to their values.
/// Weights come only from `rng`, so a seed gives the same networks every time.
///
/// A backend can wrap another one and change one thing:
///
/// ```
/// use copq::{Actor, ActorKind, Backend, Critic, EnvSpec, Networks, Result, Rng};
/// # use copq::Stream;
///
/// /// Another backend's networks, with a smaller policy.
/// struct SmallActor<B>(B);
///
/// impl<B: Backend> Backend for SmallActor<B> {
///     fn critics(
///         &self,
///         spec: &EnvSpec,
///         networks: &Networks,
///         count: usize,
///         rng: &mut Rng,
///     ) -> Result<Box<dyn Critic>> {
///         self.0.critics(spec, networks, count, rng)
///     }
///
///     fn actor(
///         &self,
///         spec: &EnvSpec,
///         networks: &Networks,
///         kind: ActorKind,
///         rng: &mut Rng,
///     ) -> Result<Box<dyn Actor>> {
///         let small = Networks { hidden: vec![64, 64], ..networks.clone() };
///         self.0.actor(spec, &small, kind, rng)
///     }
/// }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let spec = EnvSpec::new("world", 1, 1).reward("time", 1.0);
/// # let mut rng = Rng::new(0, Stream::Init);
/// # let kind = ActorKind::Deterministic;
/// # assert!(SmallActor(Still).actor(&spec, &Networks::default(), kind, &mut rng).is_ok());
/// ```
pub trait Backend {
    /// `count` critics, each of which maps an observation and an action to one value per objective
    /// of the task.
    fn critics(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>>;

    /// A policy for the task.
    fn actor(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        rng: &mut Rng,
    ) -> Result<Box<dyn Actor>>;

    /// A policy for on-policy learning. The default returns [`Error::Unsupported`].
    fn policy(
        &self,
        _spec: &EnvSpec,
        _networks: &Networks,
        _rng: &mut Rng,
    ) -> Result<Box<dyn GaussianPolicy>> {
        Err(off_policy("policy"))
    }

    /// A critic of observations for on-policy learning. The default returns [`Error::Unsupported`].
    fn value(
        &self,
        _spec: &EnvSpec,
        _networks: &Networks,
        _rng: &mut Rng,
    ) -> Result<Box<dyn StateValue>> {
        Err(off_policy("value"))
    }
}

fn off_policy(method: &str) -> Error {
    let what = format!("on-policy methods need Backend::{method}, which this backend has not");
    Error::Unsupported { what }
}

/// Which kind of policy a method learns.
///
/// ```
/// use copq::{ActorKind, Method};
///
/// assert_eq!(Method::td3().actor(), ActorKind::Deterministic);
/// assert_eq!(Method::sac().actor(), ActorKind::Gaussian);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActorKind {
    /// One action for each observation (TD3).
    Deterministic,
    /// A Gaussian, squashed by tanh (SAC).
    Gaussian,
    /// A Gaussian that is not squashed, with its own deviations (PPO). Learners ask for it through
    /// [`Backend::policy`]; a stored policy asks for it through [`Backend::actor`].
    Normal,
}
