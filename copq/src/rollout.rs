//! The loop of an episode: scale an action, step the environment, add up the rewards.

use crate::error::check_len;
use crate::{Env, Error, Outcome, Result, State};

/// A finished or running episode.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let mut env = world::World::new();
/// use copq::{Episode, Outcome, Rollout};
///
/// // An environment that gives a reward of 0.5 for each of 3 steps.
/// let mut rollout = Rollout::new(env)?;
/// rollout.reset(0)?;
/// while rollout.step(&[0.0])? == Outcome::Running {}
/// let wanted = Episode { returns: vec![1.5], length: 3, outcome: Outcome::Truncated };
/// assert_eq!(*rollout.episode(), wanted);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// Undiscounted return of each objective.
    pub returns: Vec<f64>,
    /// The number of environment steps it took.
    pub length: u64,
    /// Terminated or truncated; running until then.
    pub outcome: Outcome,
}

/// An environment with an episode in it, driven by actions in [-1, 1].
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let env = world::World::new();
/// use copq::{Outcome, Rollout};
///
/// let mut rollout = Rollout::new(env)?;
/// rollout.reset(7)?; // the episode of seed 7
/// while rollout.step(&[0.5])? == Outcome::Running {}
/// assert_eq!((rollout.episode().length, rollout.episode().returns[0]), (3, 1.5));
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Rollout<E> {
    env: E,
    /// The current observation, and the one before the last step.
    obs: Vec<f32>,
    previous_obs: Vec<f32>,
    /// In the environment's own units.
    action: Vec<f32>,
    reward: Vec<f32>,
    episode: Episode,
}

impl<E: Env> std::fmt::Debug for Rollout<E> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Rollout")
            .field("env", &self.env.spec().name)
            .field("episode", &self.episode)
            .finish_non_exhaustive()
    }
}

impl<E: Env> Rollout<E> {
    /// Takes an environment and checks its description. There is no episode before
    /// [`Rollout::reset`].
    pub fn new(env: E) -> Result<Self> {
        let spec = env.spec();
        spec.check()?;
        let objectives = spec.objectives.len();
        Ok(Self {
            obs: vec![0.0; spec.obs_len],
            previous_obs: vec![0.0; spec.obs_len],
            action: vec![0.0; spec.action_len()],
            reward: vec![0.0; objectives],
            episode: Episode {
                returns: vec![0.0; objectives],
                length: 0,
                outcome: Outcome::Truncated,
            },
            env,
        })
    }

    /// Begins the episode of a seed.
    pub fn reset(&mut self, seed: u64) -> Result<()> {
        self.episode.returns.fill(0.0);
        self.episode.length = 0;
        self.episode.outcome = Outcome::Truncated; // until there is one
        self.env.reset(seed, &mut self.obs)?;
        self.check_numbers("observation", &self.obs, |i| format!("component {i}"))?;
        self.episode.outcome = Outcome::Running;
        Ok(())
    }

    /// Takes one step with an action in [-1, 1]. A value that is not finite (NaN, infinity) is an
    /// error, before it counts. So is an episode that continues past the horizon: a caller that
    /// waits for its end would wait for ever.
    pub fn step(&mut self, unit_action: &[f32]) -> Result<Outcome> {
        check_len("action", unit_action.len(), self.action.len())?;
        if !self.is_running() {
            return Err(Error::invalid(
                "Rollout::step",
                "a running episode (see Rollout::reset)",
                "none",
            ));
        }
        self.env.spec().scale_action(unit_action, &mut self.action);
        std::mem::swap(&mut self.obs, &mut self.previous_obs);
        let outcome = self.env.step(&self.action, &mut self.obs, &mut self.reward)?;
        let objectives = &self.env.spec().objectives;
        self.check_numbers("reward", &self.reward, |i| format!("'{}'", objectives[i].name))?;
        self.check_numbers("observation", &self.obs, |i| format!("component {i}"))?;
        self.episode.length += 1;
        self.episode.outcome = outcome;
        for (sum, &reward) in self.episode.returns.iter_mut().zip(&self.reward) {
            *sum += f64::from(reward);
        }
        self.env.spec().check_length(self.episode.length, outcome)?;
        Ok(outcome)
    }

    /// Whether there is an episode that has not ended.
    pub fn is_running(&self) -> bool {
        self.episode.outcome == Outcome::Running
    }

    /// Ends the episode where it is; the next one begins with [`Rollout::reset`].
    pub(crate) fn give_up(&mut self) {
        self.episode.outcome = Outcome::Truncated;
    }

    /// An error unless everything that the environment has written is finite.
    fn check_numbers(
        &self,
        what: &str,
        values: &[f32],
        name: impl Fn(usize) -> String,
    ) -> Result<()> {
        let Some(i) = values.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        let (env, step) = (&self.env.spec().name, self.episode.length);
        let what =
            format!("environment '{env}' after {step} steps of an episode: {what}, {}", name(i));
        Err(Error::invalid(what, "a finite number", values[i]))
    }

    /// The current observation.
    pub fn obs(&self) -> &[f32] {
        &self.obs
    }

    /// The observation before the last step.
    pub fn previous_obs(&self) -> &[f32] {
        &self.previous_obs
    }

    /// The last step's reward, one number per objective.
    pub fn reward(&self) -> &[f32] {
        &self.reward
    }

    /// The episode so far.
    pub fn episode(&self) -> &Episode {
        &self.episode
    }

    /// The environment.
    pub fn env(&self) -> &E {
        &self.env
    }

    /// The environment, which must not be reset or stepped behind the rollout's back.
    pub fn env_mut(&mut self) -> &mut E {
        &mut self.env
    }

    /// Writes the running episode, if there is one.
    pub(crate) fn save(&self, state: &mut State) -> Result<()> {
        if !self.is_running() {
            return Ok(());
        }
        state.put("episode_returns", self.episode.returns.as_slice());
        state.put("episode_length", [self.episode.length]);
        state.put("obs", self.obs.as_slice());
        self.env.save(state.child_mut("env"))
    }

    /// Restores what [`Rollout::save`] wrote.
    pub(crate) fn load(&mut self, state: &State) -> Result<()> {
        self.episode.outcome = Outcome::Truncated;
        let Ok(env) = state.child("env") else { return Ok(()) };
        state.read("episode_returns", &mut self.episode.returns)?;
        state.read("obs", &mut self.obs)?;
        self.episode.length = state.get_one("episode_length")?;
        self.env.load(env)?;
        self.episode.outcome = Outcome::Running;
        Ok(())
    }
}
