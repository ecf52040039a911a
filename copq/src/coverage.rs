//! How honest a learner's bounds are: its critics' estimates, compared with actual returns.

use std::fmt;

use crate::error::check_count;
use crate::{
    Agent, Env, EnvSpec, Error, Learner, Mode, Objective, Outcome, QEstimate, Result, Rng, Rollout,
    Stream,
};

/// At most this fraction of a return may come after an episode's time limit. For that fraction, the
/// critics' estimate counts.
const REST: f64 = 0.1;

/// Which episodes and actions [`coverage()`] looks at, and of which policy.
///
/// ```
/// use copq::CoverageConfig;
///
/// let config = CoverageConfig { episodes: 100, ..CoverageConfig::default() };
/// assert_eq!((config.stride, config.bare), (10, false));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoverageConfig {
    /// Episodes to play.
    pub episodes: usize,
    /// The number of an episode's actions from one that is looked at to the next.
    pub stride: usize,
    /// Plays the policy without noise, as in evaluation, and not the policy that critics learn to
    /// value: with target smoothing (TD3), or sampled and with its entropy bonus (SAC).
    pub bare: bool,
}

impl Default for CoverageConfig {
    /// Every tenth action of ten episodes of the policy that critics learn to value.
    fn default() -> Self {
        Self { episodes: 10, stride: 10, bare: false }
    }
}

/// How often discounted returns are at least as good as the critics' bound. Prints as a table.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Coverage {
    /// The number of actions that were looked at.
    pub actions: usize,
    /// The objectives, highest priority first.
    pub objectives: Vec<ObjectiveCoverage>,
    /// Their weighted total. This is what the bound keeps low: with Cholesky, Eigen and Extremum,
    /// by at most the step times the standard deviation.
    pub total: ObjectiveCoverage,
}

/// One objective of a [`Coverage`]; all numbers are means over the actions.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ObjectiveCoverage {
    /// The objective's name.
    pub name: String,
    /// The actual discounted return.
    pub discounted: f64,
    /// The critics' mean.
    pub q_mean: f64,
    /// Their bound.
    pub bound: f64,
    /// Their standard deviation (root mean square).
    pub q_std: f64,
    /// The actual return less the critics' mean (root mean square).
    pub rmse: f64,
    /// How often the actual return was at least as good as the bound; for a cost, at most as large.
    pub coverage: f64,
    /// Standard error of `coverage`; an episode's actions count as one sample. NaN for one episode.
    pub coverage_se: f64,
    /// What `coverage` would be if actual returns were normal, with the critics' mean and standard
    /// deviation.
    pub nominal: f64,
}

/// Plays a learner's policy in the episodes in which it is evaluated, and compares the discounted
/// return after some of its actions with the critics' estimates for them.
///
/// An action is left out if over a tenth of its return may come after the episode's time limit, or
/// after the point where the environment cut the episode off. This also applies to episodes that
/// end by themselves. For what comes after, the critics' estimate counts.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let backend = Still;
/// use copq::{AdjustedEnv, CoverageConfig, Env, Learner, Method, coverage};
///
/// // Each of an episode's 3 steps costs 0.5 and is worth 0.5; these critics say 0 for both.
/// let env = AdjustedEnv::new(world::World::with_cost()).weights("-1,1")?;
/// let mut method = Method::cop_td3();
/// method.config.discount = 0.2;
/// let mut learner = Learner::new(method, env.spec(), &backend, 0)?;
///
/// let config = CoverageConfig { episodes: 2, stride: 1, bare: true };
/// let coverage = coverage(&mut learner, env, config)?;
/// let [time, rest] = &coverage.objectives[..] else { unreachable!() };
/// // Both the cost and the reward were larger than the bound.
/// assert_eq!((time.coverage, rest.coverage), (0.0, 1.0));
/// // 0.5 + 0.1 + 0.02 and 0.5 + 0.1; an episode's last action is left out.
/// assert_eq!(coverage.actions, 4);
/// assert!((time.discounted - 0.61).abs() < 1e-6);
/// # Ok::<(), copq::Error>(())
/// ```
pub fn coverage(learner: &mut Learner, env: impl Env, config: CoverageConfig) -> Result<Coverage> {
    for (what, count) in [("episodes", config.episodes), ("stride", config.stride)] {
        check_count(what, count)?;
    }
    learner.check_spec(env.spec())?;
    let mut sums = Sums::new(env.spec(), learner.discount());
    let mut seeds = Rng::new(learner.seed(), Stream::Evaluation);
    let mut player = Player::new(learner, Rollout::new(env)?, config);
    for _ in 0..config.episodes {
        sums.add_episode(&player.play(seeds.next_u64())?);
    }
    sums.means()
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let actions = self.actions;
        writeln!(
            f,
            "| {actions} actions | discounted return | Q mean | Q bound | Q std | RMSE | coverage | nominal |"
        )?;
        writeln!(f, "|---|--:|--:|--:|--:|--:|--:|--:|")?;
        for of in self.objectives.iter().chain([&self.total]) {
            let ObjectiveCoverage { name, discounted, q_mean, bound, q_std, rmse, .. } = of;
            let [coverage, se, nominal] =
                [of.coverage, of.coverage_se, of.nominal].map(|share| 100.0 * share);
            let se = if se.is_nan() { "?".to_owned() } else { format!("{se:.0}") };
            writeln!(
                f,
                "| {name} | {discounted:.2} | {q_mean:.2} | {bound:.2} | {q_std:.2} | {rmse:.2} | {coverage:.0} ± {se} % | {nominal:.0} % |"
            )?;
        }
        Ok(())
    }
}

/// What was recorded of an episode: a return is added up from its end.
struct Played {
    /// `steps x objectives`
    rewards: Vec<f32>,
    /// The entropy bonus of each step's action.
    bonuses: Vec<Option<(usize, f64)>>,
    /// The critics' estimates for some steps' actions.
    looks: Vec<(usize, QEstimate)>,
    /// Their estimate for what comes after the end, if something does.
    rest: Option<Vec<f64>>,
}

struct Player<'a, E> {
    learner: &'a mut Learner,
    rollout: Rollout<E>,
    config: CoverageConfig,
    noise: Rng,
    action: Vec<f32>,
}

impl<'a, E: Env> Player<'a, E> {
    fn new(learner: &'a mut Learner, rollout: Rollout<E>, config: CoverageConfig) -> Self {
        let noise = Rng::new(learner.seed(), Stream::Coverage);
        let action = vec![0.0; rollout.env().spec().action_len()];
        Self { learner, rollout, config, noise, action }
    }

    fn play(&mut self, seed: u64) -> Result<Played> {
        let mut played =
            Played { rewards: Vec::new(), bonuses: Vec::new(), looks: Vec::new(), rest: None };
        self.rollout.reset(seed)?;
        for step in 0.. {
            let bonus = self.act()?;
            played.bonuses.push(bonus);
            if step % self.config.stride == 0 {
                played.looks.push((step, self.estimate()?));
            }
            let outcome = self.rollout.step(&self.action)?;
            played.rewards.extend_from_slice(self.rollout.reward());
            if outcome == Outcome::Truncated {
                let bonus = self.act()?;
                let mut rest = self.estimate()?.mean;
                add_bonus(&mut rest, bonus);
                played.rest = Some(rest);
            }
            if outcome != Outcome::Running {
                break;
            }
        }
        Ok(played)
    }

    fn act(&mut self) -> Result<Option<(usize, f64)>> {
        let obs = self.rollout.obs();
        if self.config.bare {
            self.learner.act(obs, Mode::Exploit, &mut self.action)?;
            return Ok(None);
        }
        self.learner.target_policy_action(obs, &mut self.noise, &mut self.action)
    }

    fn estimate(&mut self) -> Result<QEstimate> {
        self.learner.estimate(self.rollout.obs(), &self.action)
    }
}

fn add_bonus(values: &mut [f64], bonus: Option<(usize, f64)>) {
    if let Some((objective, bonus)) = bonus {
        values[objective] += bonus;
    }
}

/// Sums over actions; the total is the last of the objectives.
struct Sums {
    discount: f64,
    horizon: usize,
    /// Less of a cost is better, whatever its current weight is.
    is_cost: Vec<bool>,
    actions: usize,
    of: Vec<ObjectiveCoverage>,
    /// For each episode, its actions and how many of them are covered, by objective.
    episodes: Vec<(usize, Vec<usize>)>,
}

impl Sums {
    fn new(spec: &EnvSpec, discount: f64) -> Self {
        let names = spec.names().into_iter().chain(["weighted total"]);
        let of = names
            .map(|name| ObjectiveCoverage { name: name.to_owned(), ..Default::default() })
            .collect();
        let is_cost = spec.objectives.iter().map(Objective::is_cost).collect();
        Self { discount, horizon: spec.horizon, is_cost, actions: 0, of, episodes: Vec::new() }
    }

    /// Goes back from an episode's end, where what came after is known.
    fn add_episode(&mut self, played: &Played) {
        let n = self.of.len() - 1;
        self.episodes.push((0, vec![0; n + 1]));
        let mut to_come = played.rest.clone().unwrap_or_else(|| vec![0.0; n]);
        // Beyond the end of a truncated episode, there is only the critics' own estimate.
        let end = played.rest.as_ref().map_or(self.horizon, |_| played.rewards.len() / n);
        let mut looks = played.looks.iter().rev().peekable();
        for (step, reward) in played.rewards.chunks_exact(n).enumerate().rev() {
            for (g, &r) in to_come.iter_mut().zip(reward) {
                *g = f64::from(r) + self.discount * *g;
            }
            if let Some((_, estimate)) = looks.next_if(|(at, _)| *at == step)
                && self.is_known(end, step)
            {
                self.add(estimate, &to_come);
            }
            // Q of the step before includes this bonus, but this step's own Q does not.
            add_bonus(&mut to_come, played.bonuses[step]);
        }
    }

    /// Whether most of a return comes before this end.
    fn is_known(&self, end: usize, step: usize) -> bool {
        self.discount.powf(end.saturating_sub(step) as f64) <= REST
    }

    fn add(&mut self, estimate: &QEstimate, came: &[f64]) {
        let QEstimate { mean, std, bound, weights, total_std } = estimate;
        let total = |values: &[f64]| values.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>();
        self.actions += 1;
        for i in 0..came.len() {
            let sign = if self.is_cost[i] || weights[i] < 0.0 { -1.0 } else { 1.0 };
            self.add_one(i, sign, came[i], mean[i], std[i], bound[i]);
        }
        self.add_one(came.len(), 1.0, total(came), total(mean), *total_std, total(bound));
        if let Some((actions, _)) = self.episodes.last_mut() {
            *actions += 1;
        }
    }

    /// `sign` says whether more is better, or worse.
    fn add_one(&mut self, i: usize, sign: f64, came: f64, mean: f64, std: f64, bound: f64) {
        let of = &mut self.of[i];
        of.discounted += came;
        of.q_mean += mean;
        of.bound += bound;
        of.q_std += std * std;
        of.rmse += (came - mean).powi(2);
        of.nominal += normal_share(sign * (mean - bound), std);
        if sign * (came - bound) >= 0.0
            && let Some((_, covered)) = self.episodes.last_mut()
        {
            covered[i] += 1;
        }
    }

    fn means(mut self) -> Result<Coverage> {
        if self.actions == 0 {
            let wanted = "episodes long enough to have nine tenths of an action's return in them (a \
                 smaller discount, a longer horizon)";
            let got = format!("none among those of at most {} steps", self.horizon);
            return Err(Error::invalid("coverage", wanted, got));
        }
        let count = self.actions as f64;
        for (i, of) in self.of.iter_mut().enumerate() {
            for sum in [&mut of.discounted, &mut of.q_mean, &mut of.bound, &mut of.nominal] {
                *sum /= count;
            }
            for sum in [&mut of.q_std, &mut of.rmse] {
                *sum = (*sum / count).sqrt();
            }
            let covered: usize = self.episodes.iter().map(|(_, covered)| covered[i]).sum();
            of.coverage = covered as f64 / count;
            let apart = |(actions, covered): &(usize, Vec<usize>)| {
                (covered[i] as f64 - of.coverage * *actions as f64).powi(2)
            };
            // One episode does not show how much episodes differ.
            let n = self.episodes.len() as f64;
            let sum: f64 = self.episodes.iter().map(apart).sum();
            of.coverage_se = if n > 1.0 { (sum * n / (n - 1.0)).sqrt() / count } else { f64::NAN };
        }
        // One more than there are objectives, of which there is at least one.
        let total = self.of.pop().unwrap_or_default();
        Ok(Coverage { actions: self.actions, objectives: self.of, total })
    }
}

/// How often a normal number with this standard deviation is above `-distance`.
fn normal_share(distance: f64, std: f64) -> f64 {
    if std > 0.0 { 0.5 * libm::erfc(-distance / (std * 2f64.sqrt())) } else { 0.5 }
}
