//! What a training loop needs of a learner, whatever the algorithm.

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
/// // A learner whose policy always says 0.
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

/// A learner that acts.
///
/// A rule written by hand is an agent too, and is evaluated like one that learns:
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

    /// Makes room for so many worlds that take their steps together; what had been gathered of an
    /// epoch is forgotten. The default is an error for more than one.
    fn prepare(&mut self, worlds: usize) -> Result<()> {
        if worlds == 1 {
            return Ok(());
        }
        Err(Error::invalid("worlds of an agent that learns from one at a time", 1, worlds))
    }

    /// Says that an episode has begun, in the world attended to last. One that goes on after
    /// [`Agent::load`] does not begin, and evaluation, which may come in the middle of one, does not
    /// call it: a rule with a memory knows an evaluation's episodes by [`Mode::Exploit`] alone.
    fn begin_episode(&mut self) {}

    /// Says which world the next [`Agent::act`] or [`Agent::observe`] is about, counted from 0.
    fn attend(&mut self, _world: usize) {}

    /// Writes an action in [-1, 1] for one observation.
    fn act(&mut self, obs: &[f32], mode: Mode, action: &mut [f32]) -> Result<()>;

    /// Takes in one transition; a rule that does not learn has no use for it. On-policy learners
    /// store the sample that they drew, so an action that was overridden is learned as if it had
    /// been taken, and each is observed once.
    fn observe(&mut self, _transition: Transition<'_>) -> Result<()> {
        Ok(())
    }

    /// Does the learning that one environment step is worth: nothing during the warm-up, then
    /// [`Config::updates_per_step`](crate::Config) updates.
    fn update(&mut self, _log: &mut dyn Observer) -> Result<()> {
        Ok(())
    }

    /// Whether the episode that runs shall end here, before its time, and not be counted: on-policy
    /// learners begin their epochs with new ones.
    fn ends_episode(&self) -> bool {
        false
    }

    /// What the agent believes that this action will return, discounted, a number for each
    /// objective: the critics' mean Q(s, a), or on-policy V(s). NaN for an objective without a
    /// critic of its own.
    fn value(&mut self, obs: &[f32], action: &[f32], q: &mut [f32]) -> Result<()>;

    /// Writes what acting takes to a small file, for [`Policy::read`](crate::Policy::read).
    fn save_policy(&self, _path: &Path) -> Result<()> {
        Err(Error::Unsupported { what: "this agent has no policy to write".to_owned() })
    }

    /// Writes everything that learning depends on.
    fn save(&self, _state: &mut State) -> Result<()> {
        Err(Error::cannot_be_saved("this agent", "Agent"))
    }

    /// Restores what [`Agent::save`] wrote; the next update is then the same, bit for bit.
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

    fn prepare(&mut self, worlds: usize) -> Result<()> {
        self.as_mut().prepare(worlds)
    }

    fn begin_episode(&mut self) {
        self.as_mut().begin_episode();
    }

    fn attend(&mut self, world: usize) {
        self.as_mut().attend(world);
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
