//! The interaction loop: one call is one environment step and the learning that goes with it.

use std::fmt;
use std::time::{Duration, Instant};

use crate::{Agent, Env, Error, Mode, Observer, Outcome, Result, Rng, State, Stream, Transition};

/// A finished episode of training.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// Undiscounted return of each objective.
    pub returns: Vec<f64>,
    /// Environment steps it took.
    pub length: u64,
    /// Terminated or truncated.
    pub outcome: Outcome,
}

/// Wall-clock time spent since the trainer was made (not saved: it is no part of the result).
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Choosing actions.
    pub act: Duration,
    /// Inside the environment.
    pub env: Duration,
    /// Storing experience and updating networks.
    pub update: Duration,
}

/// An agent at work in an environment. Its whole state can be saved between any two steps.
pub struct Trainer {
    env: Box<dyn Env>,
    agent: Box<dyn Agent>,
    episode_seeds: Rng,
    steps: u64,
    timing: Timing,
    obs: Vec<f32>,
    next_obs: Vec<f32>,
    unit_action: Vec<f32>,
    action: Vec<f32>,
    reward: Vec<f32>,
    episode: Option<Episode>,
}

impl fmt::Debug for Trainer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Trainer")
            .field("env", &self.env.spec().name)
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}

impl Trainer {
    /// Puts an agent into an environment; episode seeds come from `seed`.
    pub fn new(env: Box<dyn Env>, agent: Box<dyn Agent>, seed: u64) -> Result<Self> {
        let spec = env.spec();
        spec.check()?;
        let (observation, action, objectives) = (spec.observation, spec.action(), spec.objectives.len());
        Ok(Self {
            obs: vec![0.0; observation],
            next_obs: vec![0.0; observation],
            unit_action: vec![0.0; action],
            action: vec![0.0; action],
            reward: vec![0.0; objectives],
            episode_seeds: Rng::new(seed, Stream::Env),
            steps: 0,
            timing: Timing::default(),
            episode: None,
            env,
            agent,
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

    /// The agent, for evaluation.
    pub fn agent_mut(&mut self) -> &mut dyn Agent {
        self.agent.as_mut()
    }

    /// The environment's description.
    pub fn spec(&self) -> &crate::EnvSpec {
        self.env.spec()
    }

    /// Acts, steps, observes and updates once; returns the episode if it ended here.
    pub fn step(&mut self, log: &mut dyn Observer) -> Result<Option<Episode>> {
        let start = Instant::now();
        if self.episode.is_none() {
            self.env.reset(self.episode_seeds.next_u64(), &mut self.obs)?;
            let returns = vec![0.0; self.reward.len()];
            self.episode = Some(Episode { returns, length: 0, outcome: Outcome::Running });
        }
        let reset = Instant::now();
        self.agent.act(&self.obs, Mode::Explore, &mut self.unit_action)?;
        let acted = Instant::now();
        self.env.spec().scale_action(&self.unit_action, &mut self.action);
        let outcome = self.env.step(&self.action, &mut self.next_obs, &mut self.reward)?;
        self.steps += 1;
        let stepped = Instant::now();
        self.agent.observe(Transition {
            obs: &self.obs,
            action: &self.unit_action,
            reward: &self.reward,
            next_obs: &self.next_obs,
            outcome,
        })?;
        self.agent.update(log)?;
        self.timing.act += acted - reset;
        self.timing.env += (reset - start) + (stepped - acted);
        self.timing.update += stepped.elapsed();
        std::mem::swap(&mut self.obs, &mut self.next_obs);
        let episode = self.advance_episode(outcome);
        if let Some(running) = &self.episode {
            self.env.spec().check_length(running.length, outcome)?;
        }
        Ok(episode)
    }

    fn advance_episode(&mut self, outcome: Outcome) -> Option<Episode> {
        let episode = self.episode.as_mut()?;
        episode.length += 1;
        episode.outcome = outcome;
        for (sum, &reward) in episode.returns.iter_mut().zip(&self.reward) {
            *sum += f64::from(reward);
        }
        if outcome == Outcome::Running { None } else { self.episode.take() }
    }

    /// Writes everything the rest of the run depends on.
    pub fn save(&self, state: &mut State) -> Result<()> {
        state.put("steps", [self.steps]);
        self.episode_seeds.save("episode_seeds", state);
        if let Some(episode) = &self.episode {
            state.put("episode_returns", episode.returns.as_slice());
            state.put("episode_length", [episode.length]);
            state.put("obs", self.obs.as_slice());
            self.env.save(state.child_mut("env"))?;
        }
        self.agent.save(state.child_mut("agent"))
    }

    /// Goes back to what [`Trainer::save`] wrote; the next step is then the same, bit for bit.
    pub fn load(&mut self, state: &State) -> Result<()> {
        self.steps = state.get_one("steps")?;
        self.episode_seeds.load("episode_seeds", state)?;
        self.episode = None;
        if let Ok(saved) = state.child("env") {
            let mut returns = vec![0.0; self.reward.len()];
            state.read("episode_returns", &mut returns)?;
            state.read("obs", &mut self.obs)?;
            let length = state.get_one("episode_length")?;
            self.env.load(saved)?;
            self.episode = Some(Episode { returns, length, outcome: Outcome::Running });
        }
        self.agent.load(state.child("agent")?)
    }
}

/// Deterministic episodes of a policy, with what its critics promised for them.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Undiscounted returns, one vector an episode.
    pub returns: Vec<Vec<f64>>,
    /// Steps of each episode.
    pub lengths: Vec<u64>,
    /// Discounted returns from the first step, averaged over the episodes, one per objective.
    pub discounted: Vec<f64>,
    /// The mean critic's Q at the first step, averaged over the episodes: compare with `discounted`, but know that critics
    /// value the policy they are taught with, not the bare one that is evaluated. With target smoothing (TD3) its noise
    /// costs what noise costs (on benchmark A's hopper 11.6 of control: 3 components x 0.039, clipped, x 0.99 / (1 - 0.99)); with
    /// an entropy bonus (SAC) they include the bonus of the steps to come.
    pub promised: Vec<f64>,
}

impl Evaluation {
    /// The mean return of each objective.
    pub fn mean(&self) -> Vec<f64> {
        let n = self.returns.len() as f64;
        (0..self.discounted.len()).map(|i| self.returns.iter().map(|r| r[i]).sum::<f64>() / n).collect()
    }
}

/// Runs `episodes` episodes without exploration, on seeds drawn from `seed` alone: the same episodes every time.
pub fn evaluate(
    agent: &mut dyn Agent,
    env: &mut dyn Env,
    episodes: usize,
    seed: u64,
    discount: f64,
) -> Result<Evaluation> {
    if episodes == 0 {
        return Err(Error::invalid("evaluation episodes", "at least 1", 0));
    }
    let spec = env.spec().clone();
    let n = spec.objectives.len();
    let mut seeds = Rng::new(seed, Stream::Evaluation);
    let mut result =
        Evaluation { returns: Vec::new(), lengths: Vec::new(), discounted: vec![0.0; n], promised: vec![0.0; n] };
    let (mut obs, mut reward) = (vec![0.0; spec.observation], vec![0.0; n]);
    let (mut unit, mut action, mut q) = (vec![0.0; spec.action()], vec![0.0; spec.action()], vec![0.0; n]);
    for _ in 0..episodes {
        env.reset(seeds.next_u64(), &mut obs)?;
        let (mut returns, mut length, mut weight) = (vec![0.0; n], 0, 1.0 / episodes as f64);
        loop {
            agent.act(&obs, Mode::Exploit, &mut unit)?;
            if length == 0 {
                agent.value(&obs, &unit, &mut q)?;
                result.promised.iter_mut().zip(&q).for_each(|(sum, &q)| *sum += weight * f64::from(q));
            }
            spec.scale_action(&unit, &mut action);
            let outcome = env.step(&action, &mut obs, &mut reward)?;
            length += 1;
            for i in 0..n {
                returns[i] += f64::from(reward[i]);
                result.discounted[i] += weight * f64::from(reward[i]);
            }
            weight *= discount;
            spec.check_length(length, outcome)?;
            if outcome != Outcome::Running {
                break;
            }
        }
        result.returns.push(returns);
        result.lengths.push(length);
    }
    Ok(result)
}
