//! The same world under other limits.

use crate::on_policy::shows_budgets;
use crate::{Env, EnvSpec, Error, Objective, Outcome, Result, State};

/// An environment whose costs have other limits: what an episode may cost is the user's to say.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let env = world::World::with_cost();
/// use copq::{Env, LimitedEnv};
///
/// let env = LimitedEnv::new(env, [("time", 0.75)])?;
/// assert_eq!(env.spec().limit(0), Some(0.75));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct LimitedEnv<E> {
    env: E,
    spec: EnvSpec,
}

impl<E: Env> LimitedEnv<E> {
    /// Sets the limits of costs by their names.
    pub fn new<'a>(env: E, limits: impl IntoIterator<Item = (&'a str, f64)>) -> Result<Self> {
        let mut spec = env.spec().clone();
        let mut limits = limits.into_iter().peekable();
        if limits.peek().is_some() && shows_budgets(&spec) {
            let what = format!("limits of '{}'", spec.name);
            let wanted =
                "a world whose budgets are not made of limits yet (Saute goes around this)";
            return Err(Error::invalid(what, wanted, "one with budgets in sight"));
        }
        for (name, limit) in limits {
            let is_cost = |objective: &&mut Objective| objective.limit.is_some();
            let mut costs = spec.objectives.iter_mut().filter(is_cost);
            match costs.find(|cost| cost.name == name) {
                Some(cost) => cost.limit = Some(limit as f32),
                None => return Err(unknown(&spec, name)),
            }
        }
        spec.check()?;
        Ok(Self { env, spec })
    }

    /// The world under its own limits.
    pub fn env(&self) -> &E {
        &self.env
    }
}

fn unknown(spec: &EnvSpec, name: &str) -> Error {
    let costs = spec.objectives.iter().filter(|objective| objective.limit.is_some());
    let names: Vec<_> = costs.map(|cost| cost.name.as_str()).collect();
    if names.is_empty() {
        let what = format!("limit of '{name}'");
        let wanted = "a task with a cost under a limit, such as b/hopper";
        return Error::invalid(what, wanted, format!("'{}', which has none", spec.name));
    }
    Error::unknown("cost", name, &names)
}

impl<E: Env> Env for LimitedEnv<E> {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.env.reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.env.step(action, obs, reward)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.env.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.env.load(state)
    }
}
