//! How honest a learner's bounds are: what its critics believe, beside what comes.

use std::fmt;

use crate::{
    Agent, Belief, Env, EnvSpec, Error, Learner, Mode, Objective, Outcome, Result, Rng, Rollout,
    Stream,
};

/// What comes after an episode's time limit may be this part of a return at most; it counts as the
/// critics have it.
const REST: f64 = 0.1;

/// What critics believed of actions in a policy's episodes, and what came, by objective. Prints as a
/// table.
///
/// Where states and policy decide what comes, an action has one discounted return. If critics err as
/// they disagree, what comes is at least as good as a bound of k standard deviations as often as a
/// normal number is above -k: 82 % for the paper's 0.92. Critics are taught with the noise of target
/// smoothing (TD3) or with entropy (SAC); that is told from their error by [`Looks::smoothed`].
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let backend = Still;
/// use copq::{AdjustedEnv, Coverage, Env, Learner, Looks, Method};
///
/// // Episodes of 3 steps that cost 0.5 each and are worth 0.5 each; these critics say 0 of both.
/// let env = AdjustedEnv::new(world::World::with_cost()).weights("-1,1")?;
/// let mut method = Method::cop_td3();
/// method.config.discount = 0.2;
/// let mut learner = Learner::new(method, env.spec(), &backend, 0)?;
///
/// let looks = Looks { episodes: 2, every: 1, ..Looks::default() };
/// let coverage = Coverage::of(&mut learner, env, looks)?;
/// let [time, rest] = &coverage.objectives[..] else { unreachable!() };
/// // More cost came than the bound said, and more reward.
/// assert_eq!((time.kept, rest.kept), (0.0, 1.0));
/// // 0.5 + 0.1 + 0.02 and 0.5 + 0.1; an episode's last action is worth mostly what comes after it.
/// assert_eq!(coverage.actions, 4);
/// assert!((time.came - 0.61).abs() < 1e-6);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Coverage {
    /// Actions that were looked at.
    pub actions: usize,
    /// Highest priority first.
    pub objectives: Vec<Covered>,
}

/// Which episodes and actions a [`Coverage`] is of.
///
/// ```
/// use copq::Looks;
///
/// let looks = Looks { episodes: 100, ..Looks::default() };
/// assert_eq!((looks.every, looks.smoothed), (10, false));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Looks {
    /// Episodes to play.
    pub episodes: usize,
    /// Actions of an episode from one look to the next.
    pub every: usize,
    /// Plays with the noise that target actions have (TD3): what critics are taught to value. What
    /// comes is then by chance, too, and its error a little larger for that.
    pub smoothed: bool,
}

impl Default for Looks {
    /// Every tenth action of ten episodes, without noise.
    fn default() -> Self {
        Self { episodes: 10, every: 10, smoothed: false }
    }
}

/// One objective of a [`Coverage`]; all are means over the actions.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Covered {
    /// The objective.
    pub name: String,
    /// The discounted return that came.
    pub came: f64,
    /// The critics' mean.
    pub believed: f64,
    /// Their bound on the careful side.
    pub bound: f64,
    /// Their standard deviation (root mean square).
    pub std: f64,
    /// What came, less what was believed (root mean square).
    pub error: f64,
    /// How often what came was at least as good as the bound.
    pub kept: f64,
}

impl Coverage {
    /// Plays a learner's policy in the episodes in which it is evaluated, and looks at some of its
    /// actions.
    pub fn of(learner: &mut Learner, env: impl Env, looks: Looks) -> Result<Self> {
        for (what, count) in
            [("episodes", looks.episodes), ("actions from look to look", looks.every)]
        {
            if count == 0 {
                return Err(Error::invalid(what, "at least 1", 0));
            }
        }
        if looks.smoothed && learner.smoothing().is_none() {
            let what = "episodes with the targets' noise";
            return Err(Error::invalid(what, "a method with target smoothing", "none"));
        }
        let mut sums = Sums::new(env.spec());
        let discount = learner.discount();
        let mut seeds = Rng::new(learner.seed(), Stream::Evaluation);
        let mut player = Player::new(learner, Rollout::new(env)?, looks);
        for _ in 0..looks.episodes {
            sums.add_episode(&player.play(seeds.next_u64())?, discount);
        }
        sums.means()
    }
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| {} actions | came | believed | bound | std | error | kept |", self.actions)?;
        writeln!(f, "|---|--:|--:|--:|--:|--:|--:|")?;
        for Covered { name, came, believed, bound, std, error, kept } in &self.objectives {
            let kept = 100.0 * kept;
            writeln!(
                f,
                "| {name} | {came:.1} | {believed:.1} | {bound:.1} | {std:.2} | {error:.2} | {kept:.0} % |"
            )?;
        }
        Ok(())
    }
}

/// An episode: rewards, `steps x objectives`, beliefs of some steps' actions, and the critics' mean of
/// what comes after its end, if something does.
struct Played {
    rewards: Vec<f32>,
    beliefs: Vec<(usize, Belief)>,
    rest: Option<Vec<f32>>,
}

struct Player<'a, E> {
    learner: &'a mut Learner,
    rollout: Rollout<E>,
    looks: Looks,
    noise: Rng,
    action: Vec<f32>,
    belief: Belief,
}

impl<'a, E: Env> Player<'a, E> {
    fn new(learner: &'a mut Learner, rollout: Rollout<E>, looks: Looks) -> Self {
        let noise = Rng::new(learner.seed(), Stream::Smoothing);
        let action = vec![0.0; rollout.env().spec().action_len()];
        Self { learner, rollout, looks, noise, action, belief: Belief::default() }
    }

    fn play(&mut self, seed: u64) -> Result<Played> {
        let mut played = Played { rewards: Vec::new(), beliefs: Vec::new(), rest: None };
        self.rollout.reset(seed)?;
        for step in 0.. {
            self.act()?;
            if step % self.looks.every == 0 {
                played.beliefs.push((step, self.belief()?.clone()));
            }
            let outcome = self.rollout.step(&self.action)?;
            played.rewards.extend_from_slice(self.rollout.reward());
            if outcome == Outcome::Truncated {
                self.act()?;
                played.rest = Some(self.belief()?.mean.clone());
            }
            if outcome != Outcome::Running {
                break;
            }
        }
        Ok(played)
    }

    fn act(&mut self) -> Result<()> {
        self.learner.act(self.rollout.obs(), Mode::Exploit, &mut self.action)?;
        if let Some(smoothing) = self.learner.smoothing().filter(|_| self.looks.smoothed) {
            let mut noise = vec![0.0; self.action.len()];
            self.noise.fill_normal(&mut noise);
            smoothing.add(&noise, &mut self.action);
        }
        Ok(())
    }

    fn belief(&mut self) -> Result<&Belief> {
        self.learner.belief(self.rollout.obs(), &self.action, &mut self.belief)?;
        Ok(&self.belief)
    }
}

/// What is added up over actions.
struct Sums {
    is_cost: Vec<bool>,
    coverage: Coverage,
}

impl Sums {
    fn new(spec: &EnvSpec) -> Self {
        let of = |objective: &Objective| Covered {
            name: objective.name.clone(),
            came: 0.0,
            believed: 0.0,
            bound: 0.0,
            std: 0.0,
            error: 0.0,
            kept: 0.0,
        };
        let is_cost = spec.objectives.iter().map(|objective| objective.limit.is_some()).collect();
        let objectives = spec.objectives.iter().map(of).collect();
        Self { is_cost, coverage: Coverage { actions: 0, objectives } }
    }

    /// Goes back from an episode's end, where it is known what came after.
    fn add_episode(&mut self, played: &Played, discount: f64) {
        let n = self.is_cost.len();
        let mut rest = if played.rest.is_some() { 1.0 } else { 0.0 };
        let mut came: Vec<f64> = match &played.rest {
            Some(values) => values.iter().map(|&value| value.into()).collect(),
            None => vec![0.0; n],
        };
        let mut beliefs = played.beliefs.iter().rev().peekable();
        for (step, reward) in played.rewards.chunks_exact(n).enumerate().rev() {
            rest *= discount;
            came.iter_mut().zip(reward).for_each(|(g, &r)| *g = f64::from(r) + discount * *g);
            if let Some((_, belief)) = beliefs.next_if(|(at, _)| *at == step)
                && rest <= REST
            {
                self.add(belief, &came);
            }
        }
    }

    fn add(&mut self, belief: &Belief, came: &[f64]) {
        self.coverage.actions += 1;
        for (i, of) in self.coverage.objectives.iter_mut().enumerate() {
            let [mean, std, bound] =
                [&belief.mean, &belief.std, &belief.bound].map(|of| f64::from(of[i]));
            of.came += came[i];
            of.believed += mean;
            of.bound += bound;
            of.std += std * std;
            of.error += (came[i] - mean).powi(2);
            let is_kept = if self.is_cost[i] { came[i] <= bound } else { came[i] >= bound };
            of.kept += f64::from(u8::from(is_kept));
        }
    }

    fn means(mut self) -> Result<Coverage> {
        if self.coverage.actions == 0 {
            let wanted = "episodes that end, or run on until nine tenths of a return have come";
            return Err(Error::invalid("coverage", wanted, "none"));
        }
        let count = self.coverage.actions as f64;
        for of in &mut self.coverage.objectives {
            for sum in [&mut of.came, &mut of.believed, &mut of.bound, &mut of.kept] {
                *sum /= count;
            }
            for sum in [&mut of.std, &mut of.error] {
                *sum = (*sum / count).sqrt();
            }
        }
        Ok(self.coverage)
    }
}
