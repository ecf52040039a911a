//! Another priority order of an environment's objectives.

use crate::{Env, EnvSpec, Error, Outcome, Result, State};

/// An environment whose objectives come in another order, highest priority first; weights and
/// limits follow, and the entropy bonus stays with its objective.
///
/// Only methods that know priorities care: for Cholesky the order says whose uncertainty is
/// answered for first.
///
/// ```
/// # use copq::{Env, EnvSpec, OrderedEnv, Outcome, Result};
/// # struct World(EnvSpec);
/// # impl Env for World {
/// #     fn spec(&self) -> &EnvSpec { &self.0 }
/// #     fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> { obs[0] = 0.0; Ok(()) }
/// #     fn step(&mut self, _: &[f32], _: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
/// #         reward.copy_from_slice(&[1.0, 2.0]); Ok(Outcome::Running)
/// #     }
/// # }
/// # let env = World(EnvSpec::new("world", 1, 1).reward("safety", 1.0).reward("velocity", 1.0));
/// let env = OrderedEnv::new(env, &["velocity", "safety"])?; // or OrderedEnv::parse(env, "vs")
/// assert_eq!(env.spec().names(), ["velocity", "safety"]);
/// # Ok::<(), copq::Error>(())
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
        f.debug_struct("OrderedEnv")
            .field("objectives", &self.spec.objectives)
            .finish_non_exhaustive()
    }
}

impl OrderedEnv {
    /// Puts the objectives in this order; every one must be named once.
    pub fn new(env: impl Env + 'static, objectives: &[impl AsRef<str>]) -> Result<Self> {
        let old = env.spec();
        old.check()?;
        let names = old.names();
        let position = |name: &str| {
            names
                .iter()
                .position(|known| *known == name)
                .ok_or_else(|| Error::unknown("objective", name, &names))
        };
        let from =
            objectives.iter().map(|name| position(name.as_ref())).collect::<Result<Vec<_>>>()?;
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
            entropy: old.entropy_objective().map(|i| old.objectives[i].name.clone()),
            ..old.clone()
        };
        Ok(Self { reward: vec![0.0; from.len()], env: Box::new(env), spec, from })
    }

    /// The order as people write it: names with commas between, or first letters, such as `vsc`
    /// (velocity, safety, control).
    pub fn parse(env: impl Env + 'static, order: &str) -> Result<Self> {
        let names = env.spec().names();
        let objectives = match order.contains(',') || names.contains(&order) {
            true => order.split(',').map(str::trim).collect::<Vec<_>>(),
            false => {
                order.chars().map(|letter| only(&names, letter)).collect::<Result<Vec<_>>>()?
            }
        };
        let objectives: Vec<_> = objectives.into_iter().map(str::to_owned).collect();
        Self::new(env, &objectives)
    }
}

/// The one name that begins with a letter.
fn only<'a>(names: &[&'a str], letter: char) -> Result<&'a str> {
    let mut found = names.iter().filter(|name| name.starts_with(letter));
    match (found.next(), found.next()) {
        (Some(name), None) => Ok(name),
        _ => {
            let wanted = format!(
                "first letters, one objective each, or names with commas between: {}",
                names.join(",")
            );
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
        // What the world does not write is seen as such, and not as the last step's.
        self.reward.fill(f32::NAN);
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
