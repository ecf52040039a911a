//! What a policy is worth: whole episodes without exploration.

use std::fmt;

use crate::error::check_count;
use crate::{Agent, Env, Mode, Outcome, Result, Rng, Rollout, Stream};

/// Deterministic episodes of a policy, with what its critics expected of them. Prints as a small
/// table.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let mut env = world::World::new();
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let mut agent = still::Still;
/// // Episodes of 3 steps with a reward of 0.5 for each; the agent's discount is 0.9.
/// let evaluation = copq::evaluate(&mut agent, env, 2)?;
/// assert_eq!(evaluation.returns, [[1.5], [1.5]]);
/// assert_eq!(evaluation.to_string(), "2 episodes of 3.0 steps\n  time       1.5\n");
///
/// // The return was 0.5 + 0.45 + 0.405; the critics had estimated 1.25.
/// assert!((evaluation.discounted[0] - 1.355).abs() < 1e-6);
/// assert_eq!(evaluation.q_start, [1.25]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Evaluation {
    /// The objectives' names, highest priority first.
    pub objectives: Vec<String>,
    /// Undiscounted returns, one vector per episode.
    pub returns: Vec<Vec<f64>>,
    /// Steps of each episode.
    pub lengths: Vec<u64>,
    /// Discounted returns from the first step, averaged over the episodes, one per objective.
    pub discounted: Vec<f64>,
    /// The critics' mean Q at the first step, averaged over the episodes. Compare it with
    /// `discounted`, but note that critics value the policy that they are taught with, not the
    /// noise-free one that is evaluated. With target smoothing (TD3), its noise costs something
    /// (on benchmark A's hopper 11.6 of control: 3 components x 0.039, clipped, x 0.99 / (1 -
    /// 0.99)). With an entropy bonus (SAC), they include the bonus of the steps to come.
    pub q_start: Vec<f64>,
}

impl Evaluation {
    /// The mean return of each objective.
    pub fn mean(&self) -> Vec<f64> {
        let n = self.returns.len() as f64;
        (0..self.discounted.len())
            .map(|i| self.returns.iter().map(|r| r[i]).sum::<f64>() / n)
            .collect()
    }

    /// The mean number of steps of an episode.
    pub fn mean_length(&self) -> f64 {
        self.lengths.iter().sum::<u64>() as f64 / self.lengths.len() as f64
    }
}

impl fmt::Display for Evaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let episodes = self.returns.len();
        writeln!(f, "{episodes} episodes of {:.1} steps", self.mean_length())?;
        let width = self.objectives.iter().map(String::len).max().unwrap_or(0);
        for (name, mean) in self.objectives.iter().zip(self.mean()) {
            writeln!(f, "  {name:width$} {mean:9.1}")?;
        }
        Ok(())
    }
}

/// Runs `episodes` episodes without exploration. Their seeds come only from the agent's seed, so
/// they are the same episodes every time. An error for an environment that a learner was not made
/// for, and for rewards that are not finite numbers.
pub fn evaluate<A: Agent + ?Sized>(
    agent: &mut A,
    env: impl Env,
    episodes: usize,
) -> Result<Evaluation> {
    evaluate_while(agent, env, episodes, || Ok(()))
}

/// Like [`evaluate`], but calls `may_go_on` before every step. An error from it ends the
/// evaluation, for example because somebody wants it to stop.
pub fn evaluate_while<A: Agent + ?Sized>(
    agent: &mut A,
    env: impl Env,
    episodes: usize,
    may_go_on: impl Fn() -> Result<()>,
) -> Result<Evaluation> {
    check_count("evaluation episodes", episodes)?;
    let spec = env.spec();
    agent.check_spec(spec)?;
    let n = spec.objectives.len();
    let mut result = Evaluation {
        objectives: spec.names().into_iter().map(str::to_owned).collect(),
        returns: Vec::new(),
        lengths: Vec::new(),
        discounted: vec![0.0; n],
        q_start: vec![0.0; n],
    };
    let discount = agent.discount();
    let mut seeds = Rng::new(agent.seed(), Stream::Evaluation);
    let mut action = vec![0.0; spec.action_len()];
    let mut q = vec![0.0; n];
    let mut rollout = Rollout::new(env)?;
    for _ in 0..episodes {
        rollout.reset(seeds.next_u64())?;
        let mut weight = 1.0 / episodes as f64;
        agent.act(rollout.obs(), Mode::Exploit, &mut action)?;
        agent.value(rollout.obs(), &action, &mut q)?;
        for (sum, &q) in result.q_start.iter_mut().zip(&q) {
            *sum += weight * f64::from(q);
        }
        loop {
            may_go_on()?;
            let outcome = rollout.step(&action)?;
            for (sum, &reward) in result.discounted.iter_mut().zip(rollout.reward()) {
                *sum += weight * f64::from(reward);
            }
            weight *= discount;
            if outcome != Outcome::Running {
                break;
            }
            agent.act(rollout.obs(), Mode::Exploit, &mut action)?;
        }
        result.returns.push(rollout.episode().returns.clone());
        result.lengths.push(rollout.episode().length);
    }
    Ok(result)
}
