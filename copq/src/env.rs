//! The environment: a Markov decision process with a vector of rewards, in priority order.

use crate::{EnvSpec, Error, Result, State};

/// How a step left the episode. Only [`Outcome::Terminated`] stops the bootstrap (`d = 1` in the TD
/// target).
///
/// ```
/// use copq::Outcome;
///
/// /// A robot that falls on the last step has fallen all the same.
/// fn outcome(fallen: bool, step: usize, horizon: usize) -> Outcome {
///     match fallen {
///         true => Outcome::Terminated,
///         false if step == horizon => Outcome::Truncated,
///         false => Outcome::Running,
///     }
/// }
/// assert_eq!(outcome(true, 1_000, 1_000), Outcome::Terminated);
/// assert_eq!(outcome(false, 1_000, 1_000), Outcome::Truncated);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// The episode continues.
    Running,
    /// The task itself ended it: the robot fell, the goal was reached.
    Terminated,
    /// Time ran out; the state is as valuable as any other.
    Truncated,
}

/// An environment with vector rewards. It never resets itself: after an outcome other than
/// [`Outcome::Running`] the caller calls [`Env::reset`].
///
/// Three methods suffice. `save` and `load` let a run stop in mid-episode and resume bit for bit.
///
/// ```
/// use copq::{Env, EnvSpec, Outcome, Result, check_env};
///
/// /// Counts to ten, pushed or not.
/// struct Count(EnvSpec, f32);
///
/// impl Env for Count {
///     fn spec(&self) -> &EnvSpec {
///         &self.0
///     }
///
///     fn reset(&mut self, _seed: u64, obs: &mut [f32]) -> Result<()> {
///         self.1 = 0.0;
///         obs[0] = self.1;
///         Ok(())
///     }
///
///     fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
///         self.1 += 1.0;
///         obs[0] = self.1;
///         reward[0] = -action[0].abs();
///         Ok(if self.1 < 10.0 { Outcome::Running } else { Outcome::Truncated })
///     }
/// }
///
/// let mut env = Count(EnvSpec::new("count", 1, 1).reward("rest", 1.0).horizon(10), 0.0);
/// assert_eq!(check_env(&mut env)?.lengths, [10; 5]);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Env: Send {
    /// The description, the same at every call.
    fn spec(&self) -> &EnvSpec;

    /// Begins an episode that depends only on `seed`; writes the first observation.
    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()>;

    /// Applies an action within the bounds; writes the next observation and the reward vector, raw
    /// (unweighted).
    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome>;

    /// Writes everything that [`Env::load`] needs to resume bit for bit. It may be called between
    /// any two steps, and before the first reset. The default returns [`Error::Unsupported`]. An
    /// environment that cannot be saved returns the same, which is how callers recognise it.
    fn save(&self, _state: &mut State) -> Result<()> {
        Err(cannot_be_saved(self.spec()))
    }

    /// Restores what [`Env::save`] wrote. The default returns [`Error::Unsupported`].
    fn load(&mut self, _state: &State) -> Result<()> {
        Err(cannot_be_saved(self.spec()))
    }
}

fn cannot_be_saved(spec: &EnvSpec) -> Error {
    Error::cannot_be_saved(&format!("environment '{}'", spec.name), "Env")
}

impl<E: Env + ?Sized> Env for Box<E> {
    fn spec(&self) -> &EnvSpec {
        self.as_ref().spec()
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.as_mut().reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.as_mut().step(action, obs, reward)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.as_ref().save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.as_mut().load(state)
    }
}

impl<E: Env + ?Sized> Env for &mut E {
    fn spec(&self) -> &EnvSpec {
        (**self).spec()
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        (**self).reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        (**self).step(action, obs, reward)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        (**self).save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        (**self).load(state)
    }
}
