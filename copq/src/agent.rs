//! What a training loop needs from a learner, whatever the algorithm.

use std::path::Path;

use crate::{EnvSpec, Error, Observer, Outcome, Result, State};

/// How to choose an action.
///
/// ```
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let backend = Still;
/// use copq::{Agent, EnvSpec, Learner, Method, Mode};
///
/// // A learner whose policy always returns 0.
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("speed", 1.0);
/// let mut learner = Learner::new(Method::cop_td3(), &spec, &backend, 0)?;
/// let mut action = [0.0];
/// learner.act(&[0.1, 0.2], Mode::Explore, &mut action)?;
/// assert_ne!(action, [0.0]);
/// learner.act(&[0.1, 0.2], Mode::Exploit, &mut action)?;
/// assert_eq!(action, [0.0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// With the agent's exploration, for collecting data.
    Explore,
    /// The policy's best guess, without noise, for evaluation.
    Exploit,
}

/// One step of experience; actions in [-1, 1].
///
/// ```
/// use copq::{EnvSpec, Outcome, Replay, Transition};
///
/// let fall = Transition {
///     obs: &[0.3, 1.0],
///     action: &[0.5],
///     reward: &[0.0, 0.2], // one number for each of two objectives
///     next_obs: &[0.9, 1.5],
///     outcome: Outcome::Terminated,
/// };
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("progress", 1.0);
/// let mut replay = Replay::new(&spec, 1_000)?;
/// replay.push(fall)?;
/// assert_eq!(replay.len(), 1);
/// # Ok::<(), copq::Error>(())
/// ```
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

/// Something that acts, and may learn.
///
/// A rule written by hand is also an agent, and is evaluated like one that learns:
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let mut env = world::World::new();
/// use copq::{Agent, Mode, Result, evaluate};
///
/// /// Steers against what it sees, with half the force.
/// struct Against;
///
/// impl Agent for Against {
///     fn seed(&self) -> u64 { 0 }
///     fn discount(&self) -> f64 { 0.99 }
///     fn act(&mut self, obs: &[f32], _: Mode, action: &mut [f32]) -> Result<()> {
///         action[0] = (-0.5 * obs[0]).clamp(-1.0, 1.0);
///         Ok(())
///     }
///     fn value(&mut self, _: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
///         q.fill(f32::NAN); // it has no opinion
///         Ok(())
///     }
/// }
///
/// let evaluation = evaluate(&mut Against, env, 10)?;
/// assert_eq!(evaluation.mean(), [1.5]);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Agent: Send {
    /// The seed from which all its random numbers come, and also the episodes of a
    /// [`Trainer`](crate::Trainer).
    fn seed(&self) -> u64;

    /// gamma, the discount of its values. Evaluation compares them with discounted returns.
    fn discount(&self) -> f64;

    /// An error for an environment that the agent was not made for: one with a different task,
    /// different objectives or a different order of them.
    fn check_spec(&self, _spec: &EnvSpec) -> Result<()> {
        Ok(())
    }

    /// Makes room for a given number of environments that step together, and discards what was
    /// gathered of an epoch. The default is an error for more than one.
    fn prepare(&mut self, envs: usize) -> Result<()> {
        if envs == 1 {
            return Ok(());
        }
        Err(Error::invalid("environments of an agent that learns from one at a time", 1, envs))
    }

    /// Reports that an episode has begun in the environment of the last [`Agent::attend`]. An
    /// episode that resumes after [`Agent::load`] does not begin. Evaluation, which may come in the
    /// middle of an episode, does not call this: a rule with a memory recognises evaluation
    /// episodes only by [`Mode::Exploit`].
    fn begin_episode(&mut self) {}

    /// Selects the environment, counted from 0, of the next [`Agent::act`] or [`Agent::observe`].
    fn attend(&mut self, _env: usize) {}

    /// Writes an action in [-1, 1] for one observation.
    fn act(&mut self, obs: &[f32], mode: Mode, action: &mut [f32]) -> Result<()>;

    /// Takes in one transition. A rule that does not learn has no use for it. On-policy learners
    /// store the sample that they drew, so they learn from an overridden action as if it had been
    /// taken. They observe each action once.
    fn observe(&mut self, _transition: Transition<'_>) -> Result<()> {
        Ok(())
    }

    /// Does the learning for one environment step: nothing during the warm-up, then
    /// [`Config::updates_per_step`](crate::Config) updates.
    fn update(&mut self, _log: &mut dyn Observer) -> Result<()> {
        Ok(())
    }

    /// Whether the running episode should end here, before its time, and not be counted: on-policy
    /// learners begin their epochs with new episodes.
    fn ends_episode(&self) -> bool {
        false
    }

    /// Writes the discounted return that the agent expects from this action, one number per
    /// objective: the critics' mean Q(s, a), or V(s) for on-policy learners. NaN for an objective
    /// without its own critic.
    fn value(&mut self, obs: &[f32], action: &[f32], q: &mut [f32]) -> Result<()>;

    /// Writes what is needed to act to a small file, for [`Policy::read`](crate::Policy::read).
    fn save_policy(&self, _path: &Path) -> Result<()> {
        Err(Error::Unsupported { what: "this agent has no policy to write".to_owned() })
    }

    /// Writes everything that learning depends on.
    fn save(&self, _state: &mut State) -> Result<()> {
        Err(Error::cannot_be_saved("this agent", "Agent"))
    }

    /// Restores what [`Agent::save`] wrote. The next update is then the same, bit for bit.
    fn load(&mut self, _state: &State) -> Result<()> {
        Err(Error::cannot_be_saved("this agent", "Agent"))
    }
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

    fn prepare(&mut self, envs: usize) -> Result<()> {
        self.as_mut().prepare(envs)
    }

    fn begin_episode(&mut self) {
        self.as_mut().begin_episode();
    }

    fn attend(&mut self, env: usize) {
        self.as_mut().attend(env);
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

    fn ends_episode(&self) -> bool {
        self.as_ref().ends_episode()
    }

    fn value(&mut self, obs: &[f32], action: &[f32], q: &mut [f32]) -> Result<()> {
        self.as_mut().value(obs, action, q)
    }

    fn save_policy(&self, path: &Path) -> Result<()> {
        self.as_ref().save_policy(path)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.as_ref().save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.as_mut().load(state)
    }
}
