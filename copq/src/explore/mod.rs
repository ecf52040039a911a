//! How an agent chooses the actions that gather data.

mod optimistic;

use std::fmt::{self, Debug};

pub use optimistic::Optimistic;

use crate::{Actor, Critic, Net, Projection, Result, Rng, Scratch, State};

/// What an exploration rule may use.
pub struct Context<'a> {
    /// Environment steps observed so far.
    pub step: u64,
    /// The policy.
    pub actor: &'a mut dyn Actor,
    /// The critics, for optimistic rules.
    pub critic: &'a mut dyn Critic,
    /// The projection of the learner's targets.
    pub projection: &'a dyn Projection,
    /// The current scalarisation weights.
    pub weights: &'a [f32],
    /// The random numbers for exploration.
    pub rng: &'a mut Rng,
    /// Working memory for the projection.
    pub scratch: &'a mut Scratch,
}

impl Debug for Context<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Context")
            .field("projection", &self.projection)
            .field("weights", &self.weights)
            .finish()
    }
}

/// Chooses the action of a step that gathers data.
///
/// ```
/// use copq::{Context, Explore, GaussianNoise, Result};
/// # use copq::projection::{Cholesky, Scratch};
/// # use copq::{Rng, Stream};
///
/// /// Noise of 0.5 at the start, of 0.1 from step 100,000 on.
/// #[derive(Debug)]
/// struct Fading;
///
/// impl Explore for Fading {
///     fn act(&mut self, at: &mut Context<'_>, obs: &[f32], action: &mut [f32]) -> Result<()> {
///         let std = (0.5 - 4e-6 * at.step as f32).max(0.1);
///         GaussianNoise { std }.act(at, obs, action)
///     }
/// }
///
/// // Learner::explore(Fading) gives it to a learner. By hand, with a policy that always returns 0:
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let mut rng = Rng::new(0, Stream::Explore);
/// # let mut same_rng = rng.clone();
/// # let mut context = Context {
/// #     step: 0,
/// #     actor: &mut Still,
/// #     critic: &mut Still,
/// #     projection: &Cholesky,
/// #     weights: &[1.0, 1.0],
/// #     rng: &mut rng,
/// #     scratch: &mut Scratch::default(),
/// # };
/// let mut early = [0.0];
/// let mut late = [0.0];
/// Fading.act(&mut context, &[0.3], &mut early)?;
/// context.step = 200_000;
/// context.rng = &mut same_rng; // the same random number again
/// Fading.act(&mut context, &[0.3], &mut late)?;
/// assert!((early[0] - 5.0 * late[0]).abs() < 1e-6);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Explore: Debug + Send {
    /// Writes an action in [-1, 1] for one observation, which is normalised if the learner's
    /// networks see normalised ones.
    fn act(&mut self, context: &mut Context<'_>, obs: &[f32], action: &mut [f32]) -> Result<()>;

    /// Tells the rule that an episode has begun, in case its memory starts afresh then.
    fn begin_episode(&mut self) {}

    /// Writes what changes from step to step; the learner saves the random numbers. A rule with a
    /// memory must implement this and [`Explore::load`], or a resumed run silently differs.
    fn save(&self, _state: &mut State) {}

    /// Restores what [`Explore::save`] wrote.
    fn load(&mut self, _state: &State) -> Result<()> {
        Ok(())
    }
}

impl Explore for Box<dyn Explore> {
    fn act(&mut self, context: &mut Context<'_>, obs: &[f32], action: &mut [f32]) -> Result<()> {
        self.as_mut().act(context, obs, action)
    }

    fn begin_episode(&mut self) {
        self.as_mut().begin_episode();
    }

    fn save(&self, state: &mut State) {
        self.as_ref().save(state);
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.as_mut().load(state)
    }
}

/// The policy's action plus Gaussian noise, clipped to [-1, 1] (TD3). It is the default exploration
/// of a deterministic method, with [`Config::exploration_std`](crate::Config) as its standard
/// deviation:
///
/// ```
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let backend = still::Still;
/// use copq::{EnvSpec, GaussianNoise, Learner, Method};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("speed", 1.0);
/// let learner = Learner::new(Method::cop_td3(), &spec, &backend, 0)?;
/// let louder = learner.explore(GaussianNoise { std: 0.5 });
/// assert!(format!("{louder:?}").contains("GaussianNoise { std: 0.5 }"));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianNoise {
    /// Standard deviation, in units of half the action range.
    pub std: f32,
}

impl Explore for GaussianNoise {
    fn act(&mut self, context: &mut Context<'_>, obs: &[f32], action: &mut [f32]) -> Result<()> {
        context.actor.mode(Net::Online, obs, action)?;
        for a in action {
            *a = (*a + self.std * context.rng.normal() as f32).clamp(-1.0, 1.0);
        }
        Ok(())
    }
}

/// A sample of a stochastic policy (SAC). It is the default exploration of a stochastic method. A
/// deterministic policy has no samples:
///
/// ```
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let backend = still::Still;
/// use copq::{Agent, EnvSpec, Learner, Method, Mode, PolicySamples};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("speed", 1.0);
/// let learner = Learner::new(Method::cop_td3().warm_up(1), &spec, &backend, 0)?;
/// let mut learner = learner.explore(PolicySamples::default());
/// # learner.observe(copq::Transition {
/// #     obs: &[0.0; 2],
/// #     action: &[0.0],
/// #     reward: &[0.0; 2],
/// #     next_obs: &[0.0; 2],
/// #     outcome: copq::Outcome::Running,
/// # })?;
/// // After the warm-up of one step:
/// let error = learner.act(&[0.1, 0.2], Mode::Explore, &mut [0.0]).unwrap_err();
/// assert!(error.to_string().contains("this policy is deterministic"));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolicySamples {
    noise: Vec<f32>,
}

impl Explore for PolicySamples {
    fn act(&mut self, context: &mut Context<'_>, obs: &[f32], action: &mut [f32]) -> Result<()> {
        self.noise.resize(context.actor.noise_len(), 0.0);
        context.rng.fill_normal(&mut self.noise);
        context.actor.sample(Net::Online, obs, &self.noise, action, &mut [0.0])
    }
}

/// Uniform actions in [-1, 1], whatever the policy: the warm-up of
/// [`WarmUp::Uniform`](crate::WarmUp). A learner that always explores with it learns from data that
/// no policy has gathered:
///
/// ```
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let backend = still::Still;
/// use copq::{Agent, EnvSpec, Learner, Method, Mode, UniformActions};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("speed", 1.0);
/// let learner = Learner::new(Method::cop_td3(), &spec, &backend, 0)?;
/// let mut learner = learner.explore(UniformActions);
///
/// let mut action = [0.0];
/// learner.act(&[0.1, 0.2], Mode::Explore, &mut action)?;
/// assert!(action[0] != 0.0 && action[0].abs() <= 1.0);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UniformActions;

impl Explore for UniformActions {
    fn act(&mut self, context: &mut Context<'_>, _obs: &[f32], action: &mut [f32]) -> Result<()> {
        action.iter_mut().for_each(|a| *a = context.rng.uniform_in(-1.0, 1.0) as f32);
        Ok(())
    }
}
