//! The same world under other limits and weights.

use crate::on_policy::shows_budgets;
use crate::{Env, EnvSpec, Error, Objective, Outcome, Result, State};

/// An environment whose costs have other limits, and whose objectives other weights: what an
/// episode may cost, and what counts how much, is the user's to say.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # let env = world::World::with_cost();
/// use copq::{AdjustedEnv, Env};
///
/// let env = AdjustedEnv::new(env).limits([("time", 0.75)])?.weights("time=-0.1")?;
/// assert_eq!((env.spec().limit(0), env.spec().weights()[0]), (Some(0.75), -0.1));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct AdjustedEnv<E> {
    env: E,
    spec: EnvSpec,
}

impl<E: Env> AdjustedEnv<E> {
    /// The world as it is.
    pub fn new(env: E) -> Self {
        Self { spec: env.spec().clone(), env }
    }

    /// Sets the limits of costs by their names.
    pub fn limits<'a>(mut self, limits: impl IntoIterator<Item = (&'a str, f64)>) -> Result<Self> {
        let mut limits = limits.into_iter().peekable();
        if limits.peek().is_some() && shows_budgets(&self.spec) {
            let what = format!("limits of '{}'", self.spec.name);
            let wanted =
                "a world whose budgets are not made of limits yet (Saute goes around this)";
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

    /// Sets weights as [`read_weights`] reads them.
    pub fn weights(mut self, weights: &str) -> Result<Self> {
        for (objective, weight) in read_weights(weights, &self.spec.names())? {
            self.spec.objectives[objective].weight = weight;
        }
        self.spec.check()?;
        Ok(self)
    }

    /// The world as it describes itself.
    pub fn env(&self) -> &E {
        &self.env
    }

    /// The same, which must not be reset or stepped behind this one's back.
    pub fn env_mut(&mut self) -> &mut E {
        &mut self.env
    }
}

/// Weights as people write them, each with the number of its objective: by name, such as
/// `control=0.5,velocity=2`, or one for each objective in the world's order, such as `1,2,0.5`.
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
        self.env.step(action, obs, reward)
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
