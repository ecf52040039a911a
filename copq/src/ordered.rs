//! Another priority order of an environment's objectives.

use crate::{Env, EnvSpec, Error, Outcome, Result, State};

/// An environment whose objectives come in another order, highest priority first; weights and limits follow, and the
/// entropy bonus stays with its objective.
///
/// Only methods that know priorities care: for Cholesky the order says whose uncertainty is answered for first.
///
/// ```ignore
/// let env = OrderedEnv::new(env, &["velocity", "safety", "control"])?;
/// ```
pub struct OrderedEnv {
    env: Box<dyn Env>,
    spec: EnvSpec,
    /// Where each objective comes from.
    from: Vec<usize>,
    reward: Vec<f32>,
}

impl std::fmt::Debug for OrderedEnv {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OrderedEnv").field("objectives", &self.spec.objectives).finish_non_exhaustive()
    }
}

impl OrderedEnv {
    /// Puts the objectives in this order; every one must be named once.
    pub fn new(env: Box<dyn Env>, objectives: &[impl AsRef<str>]) -> Result<Self> {
        let old = env.spec();
        old.check()?;
        let names: Vec<_> = old.objectives.iter().map(String::as_str).collect();
        let position = |name: &str| {
            names.iter().position(|known| *known == name).ok_or_else(|| Error::unknown("objective", name, &names))
        };
        let from = objectives.iter().map(|name| position(name.as_ref())).collect::<Result<Vec<_>>>()?;
        if from.len() != names.len() || (0..names.len()).any(|i| !from.contains(&i)) {
            let got: Vec<_> = objectives.iter().map(AsRef::as_ref).collect();
            return Err(Error::invalid(
                "order of objectives",
                format!("each of {} once", names.join(", ")),
                got.join(", "),
            ));
        }
        let spec = EnvSpec {
            objectives: from.iter().map(|&i| old.objectives[i].clone()).collect(),
            weights: from.iter().map(|&i| old.weights[i]).collect(),
            limits: from.iter().map(|&i| old.limit(i)).collect(),
            entropy: old.entropy_objective().map(|i| old.objectives[i].clone()),
            ..old.clone()
        };
        Ok(Self { reward: vec![0.0; from.len()], env, spec, from })
    }

    /// The order as people write it: names with commas between, or first letters, such as `vsc` (velocity, safety,
    /// control).
    pub fn parse(env: Box<dyn Env>, order: &str) -> Result<Self> {
        let names = env.spec().objectives.clone();
        let objectives = match order.contains(',') || names.iter().any(|name| name == order) {
            true => order.split(',').map(|name| name.trim().to_owned()).collect(),
            false => order.chars().map(|letter| only(&names, letter)).collect::<Result<Vec<_>>>()?,
        };
        Self::new(env, &objectives)
    }
}

/// The one name that begins with a letter.
fn only(names: &[String], letter: char) -> Result<String> {
    let mut found = names.iter().filter(|name| name.starts_with(letter));
    match (found.next(), found.next()) {
        (Some(name), None) => Ok(name.clone()),
        _ => {
            let wanted =
                format!("first letters, one objective each, or names with commas between: {}", names.join(","));
            Err(Error::invalid("order of objectives", wanted, format!("'{letter}'")))
        }
    }
}

impl Env for OrderedEnv {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.env.reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        crate::error::check_len("reward", reward.len(), self.from.len())?;
        let outcome = self.env.step(action, obs, &mut self.reward)?;
        reward.iter_mut().zip(&self.from).for_each(|(reward, &i)| *reward = self.reward[i]);
        Ok(outcome)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.env.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.env.load(state)
    }
}
