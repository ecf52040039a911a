//! The same environment with different limits and weights, and in a different order.

use crate::error::check_len;
use crate::on_policy::shows_budgets;
use crate::{Env, EnvSpec, Error, Objective, Outcome, Result, State};

/// An environment with different limits of its costs, and different weights or a different order of
/// its objectives. The user decides what an episode may cost, what counts how much, and what comes
/// first.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let env = world::World::with_cost();
/// use copq::{AdjustedEnv, Env};
///
/// let env = AdjustedEnv::new(env).limits([("time", 0.75)])?.weights("time=-0.1")?;
/// assert_eq!((env.spec().limit(0), env.spec().weights()[0]), (Some(0.75), -0.1));
///
/// let env = env.order("rest,time")?; // or order("rt")
/// assert_eq!((env.spec().names(), env.spec().limit(1)), (vec!["rest", "time"], Some(0.75)));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct AdjustedEnv<E> {
    env: E,
    spec: EnvSpec,
    /// The original position of each objective, and what the environment wrote; both are empty in
    /// the environment's own order.
    from: Vec<usize>,
    reward: Vec<f32>,
}

impl<E: Env> AdjustedEnv<E> {
    /// Wraps an environment and changes nothing yet.
    pub fn new(env: E) -> Self {
        Self { spec: env.spec().clone(), env, from: Vec::new(), reward: Vec::new() }
    }

    /// Sets the limits of costs by name.
    pub fn limits<'a>(mut self, limits: impl IntoIterator<Item = (&'a str, f64)>) -> Result<Self> {
        let mut limits = limits.into_iter().peekable();
        if limits.peek().is_some() && shows_budgets(&self.spec) {
            let what = format!("limits of '{}'", self.spec.name);
            let wanted =
                "an environment whose budgets are not made of limits yet (Saute goes around this)";
            return Err(Error::invalid(what, wanted, "one with budgets in sight"));
        }
        for (name, limit) in limits {
            if limit < 0.0 {
                let what = format!("limit of '{name}'");
                return Err(Error::invalid(what, "at least 0, as costs are", limit));
            }
            let is_cost = |objective: &&mut Objective| objective.is_cost();
            let mut costs = self.spec.objectives.iter_mut().filter(is_cost);
            match costs.find(|cost| cost.name == name) {
                Some(cost) => cost.limit = Some(limit as f32),
                None => return Err(unknown(&self.spec, name)),
            }
        }
        self.spec.check()?;
        Ok(self)
    }

    /// Sets weights, in the format of [`read_weights`].
    pub fn weights(mut self, weights: &str) -> Result<Self> {
        for (objective, weight) in read_weights(weights, &self.spec.names())? {
            self.spec.objectives[objective].weight = weight;
        }
        self.spec.check()?;
        Ok(self)
    }

    /// Puts the objectives in a different order, highest priority first. The order is given as
    /// names separated by commas, or as first letters, such as `vsc` (velocity, safety, control),
    /// each once. Weights and limits follow, and the entropy bonus stays with its objective.
    ///
    /// The order matters only to methods that use priorities. For Cholesky, it says whose
    /// uncertainty is accounted for first.
    pub fn order(self, order: &str) -> Result<Self> {
        let names = self.spec.names();
        let objectives: Vec<&str> = match order.contains(',') || names.contains(&order) {
            true => order.split(',').map(str::trim).collect(),
            false => order.chars().map(|letter| only(&names, letter)).collect::<Result<_>>()?,
        };
        self.spec.check()?;
        let position = |name: &&str| {
            let found = names.iter().position(|known| known == name);
            found.ok_or_else(|| Error::unknown("objective", name, &names))
        };
        let from = objectives.iter().map(position).collect::<Result<Vec<_>>>()?;
        if from.len() != names.len() || (0..names.len()).any(|i| !from.contains(&i)) {
            let wanted = format!("each of {} once", names.join(", "));
            return Err(Error::invalid("order of objectives", wanted, objectives.join(", ")));
        }
        let spec = EnvSpec {
            objectives: from.iter().map(|&i| self.spec.objectives[i].clone()).collect(),
            entropy: self.spec.entropy_objective().map(|i| names[i].to_owned()),
            ..self.spec.clone()
        };
        // Positions in the environment itself, even if an order was given before.
        let own = |i: usize| self.from.get(i).copied().unwrap_or(i);
        let from: Vec<_> = from.into_iter().map(own).collect();
        Ok(Self { reward: vec![0.0; from.len()], env: self.env, spec, from })
    }

    /// The environment as it describes itself.
    pub fn env(&self) -> &E {
        &self.env
    }

    /// The environment itself, which must not be reset or stepped behind the wrapper's back.
    pub fn env_mut(&mut self) -> &mut E {
        &mut self.env
    }
}

/// Reads weights as people write them, each with the number of its objective. They are given by
/// name, such as `control=0.5,velocity=2`, or as one for each objective in the environment's order,
/// such as `1,2,0.5`.
///
/// ```
/// let weights = copq::read_weights("speed=3", &["heat", "speed"])?;
/// assert_eq!(weights, [(1, 3.0)]);
/// # Ok::<(), copq::Error>(())
/// ```
pub fn read_weights(weights: &str, names: &[&str]) -> Result<Vec<(usize, f32)>> {
    let parts: Vec<_> = weights.split(',').map(str::trim).collect();
    let is_list = parts.iter().all(|part| !part.contains('='));
    if is_list && parts.len() != names.len() {
        let wanted = format!("{} of them, for {}", names.len(), names.join(", "));
        return Err(Error::invalid("weights", wanted, weights));
    }
    let one = |(i, part): (usize, &str)| {
        let (name, number) = match part.split_once('=') {
            Some((name, number)) => (name.trim(), number.trim()),
            None if is_list => (names.get(i).copied().unwrap_or_default(), part),
            None => {
                let wanted = "all of them by name, or none";
                return Err(Error::invalid("weights", wanted, weights));
            }
        };
        let weight = number.parse().map_err(|_| {
            Error::invalid("weights", "numbers, or NAME=NUMBER, between commas", weights)
        })?;
        let objective = names.iter().position(|known| *known == name);
        Ok((objective.ok_or_else(|| Error::unknown("objective", name, names))?, weight))
    };
    let all: Vec<(usize, f32)> = parts.into_iter().enumerate().map(one).collect::<Result<_>>()?;
    match all.iter().enumerate().find(|(k, (i, _))| all[..*k].iter().any(|(known, _)| known == i)) {
        Some((_, (i, _))) => {
            Err(Error::invalid("weights", "each once", format!("{} twice", names[*i])))
        }
        None => Ok(all),
    }
}

/// The only name that begins with a letter.
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

fn unknown(spec: &EnvSpec, name: &str) -> Error {
    if let Err(error) = spec.check_has_cost(&format!("limit of '{name}'")) {
        return error;
    }
    let costs = spec.objectives.iter().filter(|objective| objective.is_cost());
    let names: Vec<_> = costs.map(|cost| cost.name.as_str()).collect();
    Error::unknown("cost", name, &names)
}

impl<E: Env> Env for AdjustedEnv<E> {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.env.reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        if self.from.is_empty() {
            return self.env.step(action, obs, reward);
        }
        check_len("reward", reward.len(), self.from.len())?;
        // What the environment does not write is seen as NaN, and not as the last step's value.
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

#[cfg(test)]
mod tests {
    use super::*;

    struct Two(EnvSpec);

    impl Env for Two {
        fn spec(&self) -> &EnvSpec {
            &self.0
        }

        fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
            obs.fill(0.0);
            Ok(())
        }

        fn step(&mut self, _: &[f32], _: &mut [f32], _: &mut [f32]) -> Result<Outcome> {
            Ok(Outcome::Truncated)
        }
    }

    fn two() -> AdjustedEnv<Two> {
        AdjustedEnv::new(Two(EnvSpec::new("two", 1, 1).cost("heat", 5.0).reward("speed", 1.0)))
    }

    #[test]
    fn weights_are_a_list_or_names() -> Result<()> {
        assert_eq!(two().weights("-1, 2")?.spec().weights(), [-1.0, 2.0]);
        assert_eq!(two().weights("speed=3")?.spec().weights(), [0.0, 3.0]);
        for wrong in ["1", "1,2,3", "", "speed=", "sped=1", "speed=fast", "1,speed=2", "nan,1"] {
            assert!(two().weights(wrong).is_err(), "{wrong}");
        }
        let names = ["safety", "speed"];
        assert_eq!(read_weights("speed=2, safety=1", &names)?, [(1, 2.0), (0, 1.0)]);
        for wrong in ["speed=2,0.5", "1,speed=2", "speed=2,speed=0.5"] {
            assert!(read_weights(wrong, &names).is_err(), "{wrong}");
        }
        Ok(())
    }

    #[test]
    fn limits_are_of_costs() -> Result<()> {
        assert_eq!(two().limits([("heat", 2.0)])?.spec().limit(0), Some(2.0));
        for wrong in [("speed", 2.0), ("heat", -2.0), ("heat", f64::NAN)] {
            assert!(two().limits([wrong]).is_err(), "{wrong:?}");
        }
        Ok(())
    }
}
