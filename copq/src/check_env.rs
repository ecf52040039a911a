//! A first check of an environment: does it keep the contract that learners rely on?

use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};

use crate::learner::scales;
use crate::{Env, EnvSpec, Error, Outcome, Result, Rng, State};

/// Seeds that [`check_env`] plays an episode with.
const SEEDS: u64 = 5;

/// Steps after which an episode with a later horizon is broken off.
const PATIENCE: usize = 100_000;

/// What [`check_env`] saw while it played with random actions.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let mut env = world::World::new();
/// use copq::{check_env, Outcome};
///
/// // Episodes of 3 steps with a reward of 0.5 for each, in an environment without Env::save.
/// let report = check_env(&mut env)?;
/// assert_eq!(report.lengths, [3; 5]);
/// assert_eq!(report.outcomes, [Outcome::Truncated; 5]);
/// assert_eq!(report.reward_range, [(0.5, 0.5)]);
/// assert!(!report.saves && report.warnings.is_empty());
/// print!("{report}");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnvReport {
    /// Steps of each episode.
    pub lengths: Vec<usize>,
    /// How each episode ended; `Running` if it was broken off after 100,000 steps.
    pub outcomes: Vec<Outcome>,
    /// The smallest and the largest reward of each objective.
    pub reward_range: Vec<(f32, f32)>,
    /// Whether an episode can be saved and resumes exactly. If not, a run needs
    /// `OnResume::NewEpisode`, and resumes with a new episode.
    pub saves: bool,
    /// What is allowed, but is likely to keep a learner from learning.
    pub warnings: Vec<String>,
}

impl fmt::Display for EnvReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "episodes of {:?} steps, then {:?}", self.lengths, self.outcomes)?;
        for (i, (low, high)) in self.reward_range.iter().enumerate() {
            writeln!(f, "objective {i}: rewards from {low} to {high}")?;
        }
        writeln!(f, "can be saved in mid-episode: {}", if self.saves { "yes" } else { "no" })?;
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}

/// Plays seeded random episodes and returns what it saw, or an error that says which rule was
/// broken and how. The rules: the description is consistent, every observation and reward is
/// written and finite, costs are not negative, the same seed gives the same episode, episodes end
/// by the horizon with the right [`Outcome`], and a saved episode, if it can be saved, resumes
/// exactly.
pub fn check_env(env: &mut dyn Env) -> Result<EnvReport> {
    let spec = env.spec().clone();
    spec.check()?;
    let mut report = EnvReport {
        lengths: Vec::new(),
        outcomes: Vec::new(),
        reward_range: vec![(f32::INFINITY, f32::NEG_INFINITY); spec.objectives.len()],
        saves: true,
        warnings: Vec::new(),
    };
    let mut largest_obs = 0.0f32;
    let mut episodes = Vec::new();
    for seed in 0..SEEDS {
        let episode = play(env, &spec, seed)?;
        check_repeat(env, &spec, seed, &episode)?;
        report.saves &= check_restore(env, &spec, seed, &episode)?;
        report.add(&episode);
        largest_obs = largest_obs.max(episode.largest_obs);
        episodes.push(episode);
    }
    report.check_horizon(&spec)?;
    report.warn(largest_obs, &episodes);
    if env.spec() != &spec {
        return Err(broken(
            &spec,
            "spec() changed while it ran; it must be the same at every call",
        ));
    }
    Ok(report)
}

/// What one episode showed.
#[derive(Debug)]
struct Played {
    first: u64,
    steps: Vec<Step>,
    /// The first, the last and the last but one observation.
    first_obs: Vec<f32>,
    last_obs: Vec<f32>,
    previous_obs: Vec<f32>,
    largest_obs: f32,
    reward_range: Vec<(f32, f32)>,
    outcome: Outcome,
}

/// A step, as the hash of what it wrote, so that long episodes take little memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Step(u64);

/// One step's buffers. They are filled with NaN before each call, to find what the environment does
/// not write.
struct Player<'a> {
    env: &'a mut dyn Env,
    spec: &'a EnvSpec,
    actions: Rng,
    obs: Vec<f32>,
    reward: Vec<f32>,
    action: Vec<f32>,
}

impl<'a> Player<'a> {
    fn new(env: &'a mut dyn Env, spec: &'a EnvSpec, seed: u64) -> Self {
        Self {
            env,
            spec,
            actions: Rng::with_stream(seed, 0xac7),
            obs: vec![0.0; spec.obs_len],
            reward: vec![0.0; spec.objectives.len()],
            action: vec![0.0; spec.action_len()],
        }
    }

    fn reset(&mut self, seed: u64) -> Result<u64> {
        self.obs.fill(f32::NAN);
        self.env.reset(seed, &mut self.obs)?;
        self.check_finite("reset", "observation", &self.obs)?;
        Ok(hash(&self.obs, &[], Outcome::Running))
    }

    fn step(&mut self, number: usize) -> Result<(Step, Outcome)> {
        let unit: Vec<f32> =
            self.action.iter().map(|_| self.actions.uniform_in(-1.0, 1.0) as f32).collect();
        self.spec.scale_action(&unit, &mut self.action);
        self.obs.fill(f32::NAN);
        self.reward.fill(f32::NAN);
        let outcome = self.env.step(&self.action, &mut self.obs, &mut self.reward)?;
        let when = format!("step {number}");
        self.check_finite(&when, "observation", &self.obs)?;
        self.check_finite(&when, "reward", &self.reward)?;
        self.check_costs(&when)?;
        Ok((Step(hash(&self.obs, &self.reward, outcome)), outcome))
    }

    fn check_costs(&self, when: &str) -> Result<()> {
        for (objective, reward) in self.spec.objectives.iter().zip(&self.reward) {
            if objective.is_cost() && *reward < 0.0 {
                let name = &objective.name;
                let what = format!("{when}: the cost '{name}' is {reward}; a cost is 0 or more");
                return Err(broken(self.spec, what));
            }
        }
        Ok(())
    }

    fn check_finite(&self, when: &str, what: &str, values: &[f32]) -> Result<()> {
        match values.iter().position(|x| !x.is_finite()) {
            None => Ok(()),
            Some(i) => {
                let what = format!(
                    "{when}: {what}[{i}] is not finite, or was not written (it was NaN before \
                     the call)"
                );
                Err(broken(self.spec, what))
            }
        }
    }
}

fn play(env: &mut dyn Env, spec: &EnvSpec, seed: u64) -> Result<Played> {
    let mut player = Player::new(env, spec, seed);
    let first = player.reset(seed)?;
    let mut played = Played {
        first,
        steps: Vec::new(),
        first_obs: player.obs.clone(),
        last_obs: player.obs.clone(),
        previous_obs: Vec::new(),
        largest_obs: 0.0,
        reward_range: vec![(f32::INFINITY, f32::NEG_INFINITY); spec.objectives.len()],
        outcome: Outcome::Running,
    };
    loop {
        let (step, outcome) = player.step(played.steps.len() + 1)?;
        played.steps.push(step);
        played.outcome = outcome;
        played.largest_obs = played.largest_obs.max(scales::size(&player.obs));
        for ((low, high), &reward) in played.reward_range.iter_mut().zip(&player.reward) {
            *low = low.min(reward);
            *high = high.max(reward);
        }
        played.previous_obs = std::mem::replace(&mut played.last_obs, player.obs.clone());
        if outcome != Outcome::Running {
            return Ok(played);
        }
        if played.steps.len() >= spec.horizon {
            let what = format!(
                "still Running after {} steps; the horizon says it is Truncated by then",
                spec.horizon
            );
            return Err(broken(spec, what));
        }
        if played.steps.len() >= PATIENCE {
            return Ok(played);
        }
    }
}

/// Whether every episode's last observation is far from the one before and near to a first one. It
/// may then be the next episode's, and what happened is lost.
fn seem_to_reset_themselves(episodes: &[Played]) -> bool {
    episodes.iter().all(|episode| {
        let starts = episodes.iter().map(|other| distance(&episode.last_obs, &other.first_obs));
        let nearest = starts.fold(f32::INFINITY, f32::min);
        episode.outcome != Outcome::Running
            && 10.0 * nearest < distance(&episode.last_obs, &episode.previous_obs)
    })
}

/// The largest difference between two observations' components.
fn distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| (a - b).abs().max(most))
}

fn check_repeat(env: &mut dyn Env, spec: &EnvSpec, seed: u64, first: &Played) -> Result<()> {
    let again = play(env, spec, seed)?;
    if again.first == first.first && again.steps == first.steps {
        return Ok(());
    }
    let step = first.steps.iter().zip(&again.steps).position(|(a, b)| a != b);
    let when = match step {
        _ if first.first != again.first => "already in the first observation".to_owned(),
        Some(i) => format!("first at step {}", i + 1),
        None => "in the episode's length".to_owned(),
    };
    let what = format!(
        "two episodes of seed {seed} with the same actions differ, {when}; reset(seed) must \
         decide everything"
    );
    Err(broken(spec, what))
}

/// Saves in mid-episode, plays another seed, loads, and expects the rest of the episode bit for
/// bit; false if it cannot be saved at all.
fn check_restore(env: &mut dyn Env, spec: &EnvSpec, seed: u64, first: &Played) -> Result<bool> {
    let half = first.steps.len() / 2;
    let mut player = Player::new(env, spec, seed);
    player.reset(seed)?;
    for i in 0..half {
        player.step(i + 1)?;
    }
    let mut state = State::default();
    match player.env.save(&mut state) {
        Err(Error::Unsupported { .. }) => return Ok(false),
        saved => saved?,
    }
    let actions = player.actions.clone();
    player.reset(seed + SEEDS)?;
    player.step(1)?;
    player.env.load(&state)?;
    player.actions = actions;
    for (i, wanted) in first.steps.iter().enumerate().skip(half) {
        if player.step(i + 1)?.0 != *wanted {
            let what = format!(
                "saved after step {half} of seed {seed} and loaded: step {} differs; save() must \
                 hold all",
                i + 1
            );
            return Err(broken(spec, what));
        }
    }
    Ok(true)
}

impl EnvReport {
    fn add(&mut self, episode: &Played) {
        self.lengths.push(episode.steps.len());
        self.outcomes.push(episode.outcome);
        for (all, one) in self.reward_range.iter_mut().zip(&episode.reward_range) {
            *all = (all.0.min(one.0), all.1.max(one.1));
        }
    }

    fn warn(&mut self, largest_obs: f32, episodes: &[Played]) {
        if seem_to_reset_themselves(episodes) {
            let text = "the last observation of every episode looks like a first one; if the \
                        environment resets itself, learners never see how an episode ends";
            self.warnings.push(text.to_owned());
        }
        if largest_obs > scales::LARGE {
            self.warnings.push(scales::large_obs(largest_obs));
        }
        let rewards = self.reward_range.iter().flat_map(|&(low, high)| [low.abs(), high.abs()]);
        let largest = rewards.fold(0.0, f32::max);
        if largest > scales::LARGE {
            self.warnings.push(scales::large_reward(largest));
        }
    }

    /// If all episodes that end at the horizon are Terminated, a time limit is reported as a
    /// failure.
    fn check_horizon(&self, spec: &EnvSpec) -> Result<()> {
        let ends = self.lengths.iter().zip(&self.outcomes);
        let at_horizon: Vec<_> = ends
            .filter(|&(&length, _)| length == spec.horizon)
            .map(|(_, &outcome)| outcome)
            .collect();
        // An episode of a single step has no time limit.
        if spec.horizon > 1
            && at_horizon.len() > 1
            && at_horizon.iter().all(|&outcome| outcome == Outcome::Terminated)
        {
            let what = format!(
                "{} episodes end exactly at the horizon ({}) as Terminated; a time limit is \
                 Truncated, or values are learned as if the task ended there",
                at_horizon.len(),
                spec.horizon
            );
            return Err(broken(spec, what));
        }
        Ok(())
    }
}

fn hash(obs: &[f32], reward: &[f32], outcome: Outcome) -> u64 {
    let mut hasher = DefaultHasher::new();
    for value in obs.iter().chain(reward) {
        value.to_bits().hash(&mut hasher);
    }
    outcome.hash(&mut hasher);
    hasher.finish()
}

fn broken(spec: &EnvSpec, what: impl Into<String>) -> Error {
    Error::Env { env: spec.name.clone(), what: what.into() }
}
