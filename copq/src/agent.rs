//! What a training loop needs of a learner, whatever the algorithm.

use crate::{EnvSpec, Observer, Outcome, Result, State};

/// How to choose an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// With the agent's exploration, for collecting data.
    Explore,
    /// The policy's best guess, without noise, for evaluation.
    Exploit,
}

/// One step of experience; actions in [-1, 1].
#[derive(Clone, Copy, Debug)]
pub struct Transition<'a> {
    /// s
    pub obs: &'a [f32],
    /// a, in [-1, 1]
    pub action: &'a [f32],
    /// r, one per objective
    pub reward: &'a [f32],
    /// s', the real last observation when the episode ended here
    pub next_obs: &'a [f32],
    /// Whether the episode ended here, and how.
    pub outcome: Outcome,
}

/// A learner that acts.
pub trait Agent: Send {
    /// The seed that all its random numbers come from, and with them a
    /// [`Trainer`](crate::Trainer)'s episodes.
    fn seed(&self) -> u64;

    /// gamma, the discount of its values, which evaluation compares with discounted returns.
    fn discount(&self) -> f64;

    /// An error for a world that it was not made for: another task, other objectives or another
    /// order of them.
    fn check_spec(&self, _spec: &EnvSpec) -> Result<()> {
        Ok(())
    }

    /// Writes an action in [-1, 1] for one observation.
    fn act(&mut self, obs: &[f32], mode: Mode, action: &mut [f32]) -> Result<()>;

    /// Takes in one transition.
    fn observe(&mut self, transition: Transition<'_>) -> Result<()>;

    /// Does the learning that one environment step is worth: nothing during the warm-up, UTD
    /// updates after it.
    fn update(&mut self, log: &mut dyn Observer) -> Result<()>;

    /// The mean critic's Q(s, a), one per objective: what the agent believes this action will
    /// return.
    fn value(&mut self, obs: &[f32], action: &[f32], q: &mut [f32]) -> Result<()>;

    /// Writes everything that learning depends on.
    fn save(&self, state: &mut State) -> Result<()>;

    /// Restores what [`Agent::save`] wrote; the next update is then the same, bit for bit.
    fn load(&mut self, state: &State) -> Result<()>;
}

impl<A: Agent + ?Sized> Agent for Box<A> {
    fn seed(&self) -> u64 {
        self.as_ref().seed()
    }

    fn discount(&self) -> f64 {
        self.as_ref().discount()
    }

    fn check_spec(&self, spec: &EnvSpec) -> Result<()> {
        self.as_ref().check_spec(spec)
    }

    fn act(&mut self, obs: &[f32], mode: Mode, action: &mut [f32]) -> Result<()> {
        self.as_mut().act(obs, mode, action)
    }

    fn observe(&mut self, transition: Transition<'_>) -> Result<()> {
        self.as_mut().observe(transition)
    }

    fn update(&mut self, log: &mut dyn Observer) -> Result<()> {
        self.as_mut().update(log)
    }

    fn value(&mut self, obs: &[f32], action: &[f32], q: &mut [f32]) -> Result<()> {
        self.as_mut().value(obs, action, q)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.as_ref().save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.as_mut().load(state)
    }
}
