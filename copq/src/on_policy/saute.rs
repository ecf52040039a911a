//! An environment that shows how much of each cost's budget is left.

use super::config::SauteConfig;
use crate::error::check_len;
use crate::{Env, EnvSpec, Error, Outcome, Result, State};

/// The suffix of a task's name: with visible budgets, it is a different task.
const SUFFIX: &str = "+saute";

/// The same environment, with one more number in its observations for each of its costs: the share
/// z of the cost's budget that is left. It is 1 at first, becomes `(z - c/b) / g` after each step
/// of cost c, and is at most 0 once the budget is spent (Sootla et al. 2022). The budget b is the
/// cost's limit, discounted by g as the spending is.
///
/// Rewards stay as they are; the learner of [`Method::ppo_saute`](super::Method::ppo_saute)
/// replaces them with [`SauteConfig::unsafe_reward`] once a budget is spent.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let env = world::World::with_cost();
/// use copq::Env;
/// use copq::on_policy::{Saute, SauteConfig};
///
/// // Three steps that cost 0.5 each, and a limit of 1 on all of them.
/// let undiscounted = SauteConfig { discount: 1.0, ..SauteConfig::default() };
/// let mut env = Saute::new(env, &undiscounted)?;
/// assert_eq!((env.spec().name.as_str(), env.spec().obs_len), ("world+saute", 2));
///
/// let mut obs = [0.0; 2];
/// let mut reward = [0.0; 2];
/// env.reset(0, &mut obs)?;
/// assert_eq!(obs[1], 1.0);
/// env.step(&[0.0], &mut obs, &mut reward)?;
/// assert_eq!(obs[1], 0.5);
/// env.step(&[0.0], &mut obs, &mut reward)?;
/// assert_eq!(obs[1], 0.0); // spent
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Saute<E> {
    env: E,
    spec: EnvSpec,
    discount: f64,
    /// Each cost's position among the objectives, its budget, and what is left of it.
    costs: Vec<usize>,
    budgets: Vec<f64>,
    left: Vec<f64>,
}

impl<E> std::fmt::Debug for Saute<E> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Saute")
            .field("spec", &self.spec)
            .field("budgets", &self.budgets)
            .field("left", &self.left)
            .finish_non_exhaustive()
    }
}

impl<E: Env> Saute<E> {
    /// Shows the budgets of an environment's costs. An error if it has no costs, or a limit that
    /// leaves nothing to spend.
    pub fn new(env: E, config: &SauteConfig) -> Result<Self> {
        let old = env.spec();
        old.check()?;
        config.check()?;
        // What is left grows by 1/g per step, and is shown as f32.
        if -(old.horizon as f64) * config.discount.ln() > f64::from(f32::MAX).ln() - 10.0 {
            let wanted = format!("one whose {}th power is not too small for f32", old.horizon);
            return Err(Error::invalid("saute.discount", wanted, config.discount));
        }
        old.check_has_cost("Saute")?;
        if shows_budgets(old) {
            let wanted = "an environment that does not show its budgets yet";
            return Err(Error::invalid("Saute::new", wanted, format!("'{}'", old.name)));
        }
        let costs = old.costs();
        let budget = |&cost: &usize| {
            let limit = f64::from(old.limit(cost).unwrap_or(0.0));
            if limit > 0.0 {
                return Ok(config.budget(limit, old.horizon));
            }
            let what = format!("limit of '{}' as a budget", old.objectives[cost].name);
            Err(Error::invalid(what, "a positive number", limit))
        };
        let budgets = costs.iter().map(budget).collect::<Result<Vec<_>>>()?;
        let spec = EnvSpec {
            name: format!("{}{SUFFIX}", old.name),
            obs_len: old.obs_len + costs.len(),
            ..old.clone()
        };
        let left = vec![1.0; costs.len()];
        Ok(Self { env, spec, discount: config.discount, costs, budgets, left })
    }

    /// The environment without its budgets.
    pub fn env(&self) -> &E {
        &self.env
    }

    /// The same, mutably; it must not be reset or stepped except through this one.
    pub fn env_mut(&mut self) -> &mut E {
        &mut self.env
    }

    fn show(&self, obs: &mut [f32]) {
        obs.iter_mut().zip(&self.left).for_each(|(obs, &left)| *obs = left as f32);
    }

    /// An observation's own part, and that of the budgets.
    fn split<'a>(&self, obs: &'a mut [f32]) -> Result<(&'a mut [f32], &'a mut [f32])> {
        check_len("observation", obs.len(), self.spec.obs_len)?;
        Ok(obs.split_at_mut(self.spec.obs_len - self.costs.len()))
    }
}

/// Whether a description is of an environment that shows its budgets.
pub(crate) fn shows_budgets(spec: &EnvSpec) -> bool {
    spec.name.ends_with(SUFFIX)
}

impl<E: Env> Env for Saute<E> {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        let (own, budgets) = self.split(obs)?;
        self.env.reset(seed, own)?;
        self.left.fill(1.0);
        self.show(budgets);
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        let (own, budgets) = self.split(obs)?;
        let outcome = self.env.step(action, own, reward)?;
        for ((left, budget), &cost) in self.left.iter_mut().zip(&self.budgets).zip(&self.costs) {
            *left = (*left - f64::from(reward[cost]) / budget) / self.discount;
        }
        self.show(budgets);
        Ok(outcome)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("left", self.left.as_slice());
        self.env.save(state.child_mut("env"))
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("left", &mut self.left)?;
        self.env.load(state.child("env")?)
    }
}
