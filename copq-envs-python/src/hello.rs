//! What the worker reports about its environment before the first episode.

use copq::{EnvSpec, Error, Objective, Result};
use serde::Deserialize;

use crate::Options;

/// The worker's first message, if it is not an error.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hello {
    obs_len: usize,
    action_low: Vec<f32>,
    action_high: Vec<f32>,
    /// How many numbers a reward has; `None` if it is not a vector.
    rewards: Option<usize>,
    has_cost: bool,
    horizon: usize,
    pub frames_per_second: f64,
    pub versions: String,
}

impl Hello {
    /// The environment as learners see it.
    pub fn spec(&self, task: &str, options: &Options) -> Result<EnvSpec> {
        let names = self.names(task, options)?;
        if let Some(name) = options.limits.keys().find(|name| !names.contains(name)) {
            let names: Vec<_> = names.iter().map(String::as_str).collect();
            return Err(Error::unknown("objective", name, &names));
        }
        let mut spec = EnvSpec::new(task, self.obs_len, self.action_low.len())
            .action_bounds(&self.action_low, &self.action_high)
            .horizon(self.horizon)
            .versions(&self.versions);
        for name in names {
            spec = spec.objective(match options.limits.get(&name) {
                Some(&limit) => Objective::cost(name, limit as f32),
                None => Objective::reward(name, 1.0),
            });
        }
        spec.check()?;
        Ok(spec)
    }

    /// The objectives' names in the environment's order, with the environment's own cost first.
    fn names(&self, task: &str, options: &Options) -> Result<Vec<String>> {
        let mut names = match self.rewards {
            None => vec!["reward".to_owned()],
            Some(count) => (0..count).map(|i| format!("reward.{i}")).collect(),
        };
        if self.has_cost {
            names.insert(0, "cost".to_owned());
        }
        match options.objectives.len() {
            0 => Ok(names),
            given if given == names.len() => Ok(options.objectives.clone()),
            given => {
                let wanted = format!("{} of them, for {}", names.len(), names.join(", "));
                Err(Error::invalid(format!("objectives of {task}"), wanted, given))
            }
        }
    }
}
