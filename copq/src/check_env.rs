//! What the author of an environment runs first: does it keep the contract that learners rely on?

use crate::{Env, EnvSpec, Error, Outcome, Result, Rng, State};

/// Seeds that [`check_env`] plays an episode with.
const SEEDS: u64 = 5;

/// What [`check_env`] saw while it played with random actions.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let mut env = world::World::new();
/// use copq::{check_env, Outcome};
///
/// // Episodes of 3 steps with a reward of 0.5 for each, in a world without Env::save.
/// let report = check_env(&mut env)?;
/// assert_eq!(report.lengths, [3; 5]);
/// assert_eq!(report.outcomes, [Outcome::Truncated; 5]);
/// assert_eq!(report.reward_range, [(0.5, 0.5)]);
/// assert!(!report.saves);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnvReport {
    /// Steps of each episode.
    pub lengths: Vec<usize>,
    /// How each episode ended.
    pub outcomes: Vec<Outcome>,
    /// The smallest and the largest reward of each objective.
    pub reward_range: Vec<(f32, f32)>,
    /// Whether an episode can be saved and goes on exactly; without, a run cannot stop in
    /// mid-episode.
    pub saves: bool,
}

/// Plays seeded random episodes and returns what it saw, or an error that says which rule was
/// broken and how: the description is consistent, every observation and reward is written and
/// finite, the same seed gives the same episode, episodes end by the horizon with the right
/// [`Outcome`], and a saved episode, if it can be saved, goes on exactly.
pub fn check_env(env: &mut dyn Env) -> Result<EnvReport> {
    let spec = env.spec().clone();
    spec.check()?;
    let mut report = EnvReport {
        lengths: Vec::new(),
        outcomes: Vec::new(),
        reward_range: vec![(f32::INFINITY, f32::NEG_INFINITY); spec.objectives.len()],
        saves: true,
    };
    for seed in 0..SEEDS {
        let episode = play(env, &spec, seed)?;
        check_repeat(env, &spec, seed, &episode)?;
        report.saves &= check_restore(env, &spec, seed, &episode)?;
        report.add(&episode);
    }
    report.check_horizon(&spec)?;
    if env.spec() != &spec {
        return Err(broken(
            &spec,
            "spec() changed while it ran; it must be the same at every call",
        ));
    }
    Ok(report)
}

/// Everything that one episode showed.
#[derive(Debug, Default, PartialEq)]
struct Played {
    /// Observations and rewards, as bits, step after step.
    steps: Vec<Step>,
    first: Vec<u32>,
}

#[derive(Debug, PartialEq)]
struct Step {
    obs: Vec<u32>,
    reward: Vec<u32>,
    outcome: Outcome,
}

/// One step's buffers, filled with NaN before each call so that what the environment does not write
/// is found.
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
        let (obs, reward, action) = (
            vec![0.0; spec.obs_len],
            vec![0.0; spec.objectives.len()],
            vec![0.0; spec.action_len()],
        );
        Self { env, spec, actions: Rng::with_stream(seed, 0xac7), obs, reward, action }
    }

    fn reset(&mut self, seed: u64) -> Result<Vec<u32>> {
        self.obs.fill(f32::NAN);
        self.env.reset(seed, &mut self.obs)?;
        self.check_finite("reset", "observation", &self.obs)?;
        Ok(bits(&self.obs))
    }

    fn step(&mut self, number: usize) -> Result<Step> {
        let unit: Vec<f32> =
            self.action.iter().map(|_| self.actions.uniform_in(-1.0, 1.0) as f32).collect();
        self.spec.scale_action(&unit, &mut self.action);
        self.obs.fill(f32::NAN);
        self.reward.fill(f32::NAN);
        let outcome = self.env.step(&self.action, &mut self.obs, &mut self.reward)?;
        let when = format!("step {number}");
        self.check_finite(&when, "observation", &self.obs)?;
        self.check_finite(&when, "reward", &self.reward)?;
        Ok(Step { obs: bits(&self.obs), reward: bits(&self.reward), outcome })
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
    let mut played = Played { first: player.reset(seed)?, steps: Vec::new() };
    loop {
        let step = player.step(played.steps.len() + 1)?;
        let running = step.outcome == Outcome::Running;
        played.steps.push(step);
        if !running {
            return Ok(played);
        }
        if played.steps.len() >= spec.horizon {
            let what = format!(
                "still Running after {} steps; the horizon says it is Truncated by then",
                spec.horizon
            );
            return Err(broken(spec, what));
        }
    }
}

fn check_repeat(env: &mut dyn Env, spec: &EnvSpec, seed: u64, first: &Played) -> Result<()> {
    let again = play(env, spec, seed)?;
    if again == *first {
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
    (0..half).try_for_each(|i| player.step(i + 1).map(drop))?;
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
        if player.step(i + 1)? != *wanted {
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
        self.outcomes.extend(episode.steps.last().map(|step| step.outcome));
        for step in &episode.steps {
            for ((low, high), bits) in self.reward_range.iter_mut().zip(&step.reward) {
                let reward = f32::from_bits(*bits);
                (*low, *high) = (low.min(reward), high.max(reward));
            }
        }
    }

    /// Every episode ending at the horizon as Terminated is a time limit reported as a failure.
    fn check_horizon(&self, spec: &EnvSpec) -> Result<()> {
        let ends = self.lengths.iter().zip(&self.outcomes);
        let at_horizon: Vec<_> = ends
            .filter(|&(&length, _)| length == spec.horizon)
            .map(|(_, &outcome)| outcome)
            .collect();
        if at_horizon.len() > 1 && at_horizon.iter().all(|&outcome| outcome == Outcome::Terminated)
        {
            let what = format!(
                "{} episodes end exactly at the horizon ({}) as Terminated; a time limit is \
                 Truncated, or values are learned as if the world ended there",
                at_horizon.len(),
                spec.horizon
            );
            return Err(broken(spec, what));
        }
        Ok(())
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|x| x.to_bits()).collect()
}

fn broken(spec: &EnvSpec, what: impl Into<String>) -> Error {
    Error::Env { env: spec.name.clone(), what: what.into() }
}
