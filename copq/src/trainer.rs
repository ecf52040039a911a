//! The interaction loop: one call is one environment step and the learning that goes with it.

use std::fmt;
use std::time::{Duration, Instant};

use crate::{
    Agent, Env, EnvSpec, Episode, Error, Evaluation, Mode, Observer, Result, Rng, Rollout, State,
    Stream, Transition, evaluate_while,
};

/// Wall-clock time spent since the trainer was made (not saved: it is no part of the result).
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let env = world::World::new();
/// # let learner = still::Still;
/// use copq::{Silent, Trainer};
///
/// let mut trainer = Trainer::new(env, learner)?;
/// trainer.run(30, &mut Silent)?;
/// let spent = trainer.timing();
/// let all = spent.act + spent.env + spent.update;
/// println!("{:.0} % in the environment", 100.0 * spent.env.as_secs_f64() / all.as_secs_f64());
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct Timing {
    /// Choosing actions.
    pub act: Duration,
    /// Inside the environment.
    pub env: Duration,
    /// Storing experience and updating networks.
    pub update: Duration,
}

/// An agent at work in an environment. Its whole state can be saved between any two steps.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let env = world::World::new();
/// # let learner = still::Still;
/// use copq::{Silent, Trainer};
///
/// let mut trainer = Trainer::new(env, learner)?;
/// trainer.run(1_000, &mut Silent)?; // or step() by step()
/// println!("{}", trainer.evaluate(10)?);
/// # assert_eq!(trainer.evaluate(2)?.lengths, [3, 3]);
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Trainer<A = Box<dyn Agent>> {
    rollout: Rollout<Box<dyn Env>>,
    agent: A,
    episode_seeds: Rng,
    steps: u64,
    timing: Timing,
    action: Vec<f32>,
    world_failed: bool,
}

impl<A> fmt::Debug for Trainer<A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Trainer")
            .field("rollout", &self.rollout)
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl<A: Agent> Trainer<A> {
    /// Puts an agent into an environment; episode seeds come from the agent's seed.
    pub fn new(env: impl Env + 'static, agent: A) -> Result<Self> {
        agent.check_spec(env.spec())?;
        let action = vec![0.0; env.spec().action_len()];
        let rollout = Rollout::new(Box::new(env) as Box<dyn Env>)?;
        let episode_seeds = Rng::new(agent.seed(), Stream::Env);
        Ok(Self {
            rollout,
            agent,
            episode_seeds,
            steps: 0,
            timing: Timing::default(),
            action,
            world_failed: false,
        })
    }

    /// Environment steps done so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Where the time went.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// The agent.
    pub fn agent(&self) -> &A {
        &self.agent
    }

    /// The agent, for evaluation elsewhere.
    pub fn agent_mut(&mut self) -> &mut A {
        &mut self.agent
    }

    /// The environment.
    pub fn env(&self) -> &dyn Env {
        self.rollout.env().as_ref()
    }

    /// The episode that runs, or the last one.
    pub fn episode(&self) -> &Episode {
        self.rollout.episode()
    }

    /// The environment's description.
    pub fn spec(&self) -> &EnvSpec {
        self.rollout.env().spec()
    }

    /// So many environment steps, each with its learning.
    pub fn run(&mut self, steps: u64, log: &mut dyn Observer) -> Result<()> {
        for _ in 0..steps {
            self.step(log)?;
        }
        Ok(())
    }

    /// Acts, steps, observes and updates once; returns the episode if it ended here.
    ///
    /// After an error of the environment ([`Trainer::world_failed`]) the step has not happened, and
    /// the episode counts as truncated where it was: the trainer can be saved, and the next step
    /// begins a new one.
    pub fn step(&mut self, log: &mut dyn Observer) -> Result<Option<Episode>> {
        let start = Instant::now();
        self.world_failed = false;
        if !self.rollout.is_running() {
            let begun = self.rollout.reset(self.episode_seeds.next_u64());
            self.or_give_up(begun)?;
        }
        let reset = Instant::now();
        let chosen = self.agent.act(self.rollout.obs(), Mode::Explore, &mut self.action);
        if self.rollout.is_finite() {
            chosen?
        } else {
            self.or_give_up(chosen)?
        }
        let acted = Instant::now();
        let done = self.rollout.step(&self.action);
        let outcome = self.or_give_up(done)?;
        let stepped = Instant::now();
        let observed = self.agent.observe(Transition {
            obs: self.rollout.previous_obs(),
            action: &self.action,
            reward: self.rollout.reward(),
            next_obs: self.rollout.obs(),
            outcome,
        });
        // What an agent cannot take in is what the environment returned.
        self.or_give_up(observed)?;
        self.steps += 1;
        self.agent.update(log)?;
        self.timing.act += acted - reset;
        self.timing.env += (reset - start) + (stepped - acted);
        self.timing.update += stepped.elapsed();
        let ended = (!self.rollout.is_running()).then(|| self.rollout.episode().clone());
        if self.agent.ends_episode() {
            self.rollout.give_up();
        }
        Ok(ended)
    }

    /// Passes on what the environment answered; after an error there is no episode any more.
    fn or_give_up<T>(&mut self, answer: Result<T>) -> Result<T> {
        if answer.is_err() {
            self.world_failed = true;
            self.rollout.give_up();
        }
        answer
    }

    /// Whether the error of the last step was the environment's: its own, or about what it
    /// returned, such as NaN. [`Trainer::episode`] is what there was of the episode.
    pub fn world_failed(&self) -> bool {
        self.world_failed
    }

    /// What the policy is worth now: so many episodes without exploration, the same ones every
    /// time. They are played in the trainer's own environment, which then goes on where it was; if
    /// it cannot be saved, a new training episode begins.
    pub fn evaluate(&mut self, episodes: usize) -> Result<Evaluation> {
        self.evaluate_while(episodes, || Ok(()))
    }

    /// [`Trainer::evaluate`], with a question before every step whose error ends it.
    pub fn evaluate_while(
        &mut self,
        episodes: usize,
        may_go_on: impl Fn() -> Result<()>,
    ) -> Result<Evaluation> {
        let mut running = State::default();
        match self.rollout.save(&mut running) {
            Err(Error::Unsupported { .. }) => running = State::default(),
            saved => saved?,
        }
        let env = self.rollout.env_mut();
        let evaluation = evaluate_while(&mut self.agent, env, episodes, may_go_on);
        self.rollout.load(&running)?;
        evaluation
    }

    /// Writes everything the rest of the run depends on.
    pub fn save(&self, state: &mut State) -> Result<()> {
        state.put("steps", [self.steps]);
        self.episode_seeds.save("episode_seeds", state);
        self.rollout.save(state)?;
        self.agent.save(state.child_mut("agent"))
    }

    /// Goes back to what [`Trainer::save`] wrote; the next step is then the same, bit for bit.
    pub fn load(&mut self, state: &State) -> Result<()> {
        // The agent first: it knows what the state is of.
        self.agent.load(state.child("agent")?)?;
        self.steps = state.get_one("steps")?;
        self.episode_seeds.load("episode_seeds", state)?;
        self.rollout.load(state)
    }
}
