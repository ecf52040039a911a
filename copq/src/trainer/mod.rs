//! The interaction loop: one call is one step of every environment and the learning that goes with
//! it.

mod saved;

use std::fmt;
use std::time::Instant;

use crate::{
    Agent, Env, EnvSpec, Episode, Error, Evaluation, Mode, Observer, Outcome, Result, Rng, Rollout,
    State, Stream, Timing, Transition, evaluate_while,
};

/// Runs an agent in an environment, or in several of the same task. Its whole state can be saved
/// between any two steps.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let env = world::World::new();
/// # let learner = still::Still;
/// use copq::{Silent, Trainer};
///
/// let mut trainer = Trainer::new(env, learner)?;
/// trainer.run(1_000, &mut Silent)?; // or call step() yourself
/// println!("{}", trainer.evaluate(10)?);
/// # assert_eq!(trainer.evaluate(2)?.lengths, [3, 3]);
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Trainer<A = Box<dyn Agent>> {
    rollouts: Vec<Rollout<Box<dyn Env>>>,
    agent: A,
    episode_seeds: Rng,
    steps: u64,
    timing: Timing,
    threads: usize,
    /// For each environment: its action, and the outcome.
    actions: Vec<Vec<f32>>,
    outcomes: Vec<Result<Outcome>>,
    /// The environment that failed in the last step, and the episodes that ended in that step.
    failed: Option<usize>,
    cut_short: Vec<Episode>,
}

impl<A> fmt::Debug for Trainer<A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Trainer")
            .field("rollouts", &self.rollouts)
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl<A: Agent> Trainer<A> {
    /// Puts an agent into an environment; episode seeds come from the agent's seed.
    pub fn new(env: impl Env + 'static, agent: A) -> Result<Self> {
        Self::with_envs(vec![Box::new(env)], agent)
    }

    /// Puts an agent into several environments of the same task, which take their steps together.
    /// Several are an error for an agent that learns from one at a time, as off-policy learners do.
    pub fn with_envs(envs: Vec<Box<dyn Env>>, mut agent: A) -> Result<Self> {
        let Some(first) = envs.first() else {
            return Err(Error::invalid("environments of a trainer", "at least 1", 0));
        };
        let spec = first.spec().clone();
        agent.check_spec(&spec)?;
        for env in &envs {
            spec.check_same("one of several environments", env.spec())?;
        }
        agent.prepare(envs.len())?;
        let rollouts = envs.into_iter().map(Rollout::new).collect::<Result<Vec<_>>>()?;
        Ok(Self {
            episode_seeds: Rng::new(agent.seed(), Stream::Env),
            agent,
            steps: 0,
            timing: Timing::default(),
            threads: 1,
            actions: vec![vec![0.0; spec.action_len()]; rollouts.len()],
            outcomes: Vec::with_capacity(rollouts.len()),
            failed: None,
            cut_short: Vec::new(),
            rollouts,
        })
    }

    /// Steps several environments on this many threads (1 by default). The results are the same,
    /// bit for bit.
    pub fn threads(self, threads: usize) -> Self {
        Self { threads: threads.max(1), ..self }
    }

    /// Environment steps done so far, in all environments together.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The number of environments that take their steps together.
    pub fn env_count(&self) -> usize {
        self.rollouts.len()
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

    /// The environment, or the first of several.
    pub fn env(&self) -> &dyn Env {
        self.rollouts[0].env().as_ref()
    }

    /// The running episode, or the last one. Of several environments, it is the first one's, or
    /// that of the one that failed.
    pub fn episode(&self) -> &Episode {
        self.rollouts[self.failed.unwrap_or(0)].episode()
    }

    /// The environment's description.
    pub fn spec(&self) -> &EnvSpec {
        self.rollouts[0].env().spec()
    }

    /// Takes `steps` environment steps, each with its learning. With several environments, all take
    /// the same number of steps, and the total is rounded up.
    pub fn run(&mut self, steps: u64, log: &mut dyn Observer) -> Result<()> {
        let end = self.steps.saturating_add(steps);
        while self.steps < end {
            self.step(log)?;
        }
        Ok(())
    }

    /// One step of every environment: acts, steps, observes and updates. Returns the episodes that
    /// ended in it.
    ///
    /// If an environment fails ([`Trainer::env_failed`]), its step has not happened, and its
    /// episode counts as truncated before it. The trainer can still be saved, and the next step
    /// begins a new episode.
    pub fn step(&mut self, log: &mut dyn Observer) -> Result<Vec<Episode>> {
        self.failed = None;
        self.cut_short.clear();
        let start = Instant::now();
        for env in 0..self.rollouts.len() {
            self.begin(env)?;
        }
        let begun = Instant::now();
        for env in 0..self.rollouts.len() {
            self.act(env)?;
        }
        let acted = Instant::now();
        self.step_envs();
        let stepped = Instant::now();
        let mut ended = Vec::new();
        let mut failed = Ok(());
        let mut outcomes = std::mem::take(&mut self.outcomes);
        for (env, outcome) in outcomes.drain(..).enumerate() {
            match outcome.and_then(|outcome| self.observe(env, outcome)) {
                Ok(episode) => ended.extend(episode),
                error => failed = self.or_give_up(env, error.map(drop)),
            }
        }
        self.outcomes = outcomes;
        // Of several environments, the others have taken their steps.
        if failed.is_ok() || self.rollouts.len() > 1 {
            self.agent.update(log)?;
            if self.agent.ends_episode() {
                self.rollouts.iter_mut().for_each(Rollout::give_up);
            }
        }
        if let Err(error) = failed {
            self.cut_short.append(&mut ended);
            return Err(error);
        }
        self.timing.act += acted - begun;
        self.timing.env += (begun - start) + (stepped - acted);
        self.timing.update += stepped.elapsed();
        Ok(ended)
    }

    /// Begins an episode if none is running.
    fn begin(&mut self, env: usize) -> Result<()> {
        if self.rollouts[env].is_running() {
            return Ok(());
        }
        let begun = self.rollouts[env].reset(self.episode_seeds.next_u64());
        self.or_give_up(env, begun)?;
        self.agent.attend(env);
        self.agent.begin_episode();
        Ok(())
    }

    fn act(&mut self, env: usize) -> Result<()> {
        self.agent.attend(env);
        self.agent.act(self.rollouts[env].obs(), Mode::Explore, &mut self.actions[env])
    }

    /// Steps every environment with its action, on up to `threads` threads.
    fn step_envs(&mut self) {
        let Self { rollouts, actions, outcomes, .. } = self;
        // A caught panic in one environment may have left the outcomes of others.
        outcomes.clear();
        let steps = rollouts.iter_mut().zip(&*actions);
        if self.threads == 1 || steps.len() == 1 {
            outcomes.extend(steps.map(|(rollout, action)| rollout.step(action)));
            return;
        }
        let share = steps.len().div_ceil(self.threads);
        std::thread::scope(|scope| {
            let parts = rollouts.chunks_mut(share).zip(actions.chunks(share));
            let threads: Vec<_> = parts
                .map(|(rollouts, actions)| {
                    scope.spawn(move || {
                        let steps = rollouts.iter_mut().zip(actions);
                        steps.map(|(rollout, action)| rollout.step(action)).collect::<Vec<_>>()
                    })
                })
                .collect();
            for thread in threads {
                match thread.join() {
                    Ok(done) => outcomes.extend(done),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
        });
    }

    /// Passes the result of an environment's step to the agent; returns the episode if it ended. If
    /// the agent rejects the result, the error is about what the environment returned.
    fn observe(&mut self, env: usize, outcome: Outcome) -> Result<Option<Episode>> {
        self.agent.attend(env);
        let rollout = &self.rollouts[env];
        self.agent.observe(Transition {
            obs: rollout.previous_obs(),
            action: &self.actions[env],
            reward: rollout.reward(),
            next_obs: rollout.obs(),
            outcome,
        })?;
        self.steps += 1;
        Ok((!rollout.is_running()).then(|| rollout.episode().clone()))
    }

    /// Passes on an environment's answer. After an error, the environment no longer has an episode.
    fn or_give_up<T>(&mut self, env: usize, answer: Result<T>) -> Result<T> {
        if answer.is_err() {
            self.failed = Some(env);
            let episode = self.rollouts[env].episode();
            if episode.length > 0 {
                self.cut_short.push(episode.clone());
            }
            self.rollouts[env].give_up();
        }
        answer
    }

    /// Whether the error of the last step came from an environment: its own error, or one about
    /// what it returned, such as NaN.
    pub fn env_failed(&self) -> bool {
        self.failed.is_some()
    }

    /// The episodes that an environment's error cut short in the last step, as far as they had
    /// come, and those that ended in other environments in the same step.
    pub fn cut_short(&self) -> &[Episode] {
        &self.cut_short
    }

    /// Evaluates the current policy on `episodes` episodes without exploration, the same ones every
    /// time. They run in the trainer's own environment, which then resumes where it was. If it
    /// cannot be saved, a new training episode begins.
    pub fn evaluate(&mut self, episodes: usize) -> Result<Evaluation> {
        self.evaluate_while(episodes, || Ok(()))
    }

    /// Like [`Trainer::evaluate`], but calls `may_go_on` before every step; an error from it ends
    /// the evaluation.
    pub fn evaluate_while(
        &mut self,
        episodes: usize,
        may_go_on: impl Fn() -> Result<()>,
    ) -> Result<Evaluation> {
        let mut running = State::default();
        let rollout = &mut self.rollouts[0];
        match rollout.save(&mut running) {
            Err(Error::Unsupported { .. }) => running = State::default(),
            saved => saved?,
        }
        let env = rollout.env_mut();
        let evaluation = evaluate_while(&mut self.agent, env, episodes, may_go_on);
        rollout.load(&running)?;
        evaluation
    }
}
