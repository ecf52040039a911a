//! A custom environment, in its three methods.

use copq::{Env, EnvSpec, Outcome, Result, Rng, Stream};

/// A room that cools, and a heater: keep it warm first, spend little second.
#[derive(Debug)]
pub struct Thermostat {
    spec: EnvSpec,
    /// Degrees away from what is wanted.
    temperature: f32,
    minutes: usize,
}

impl Thermostat {
    const MINUTES: usize = 30;

    pub fn new() -> Self {
        let spec = EnvSpec::new("thermostat", 1, 1)
            .reward("comfort", 1.0)
            .reward("thrift", 0.2)
            .action_bounds(&[0.0], &[1.0])
            .horizon(Self::MINUTES);
        Self { spec, temperature: 0.0, minutes: 0 }
    }
}

impl Env for Thermostat {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.temperature = Rng::new(seed, Stream::Custom).uniform_in(-1.0, 1.0) as f32;
        self.minutes = 0;
        obs[0] = self.temperature;
        Ok(())
    }

    fn step(&mut self, heat: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.temperature = 0.9 * self.temperature + 0.5 * heat[0] - 0.2;
        self.minutes += 1;
        obs[0] = self.temperature;
        reward.copy_from_slice(&[-self.temperature.abs(), -heat[0]]);
        let over = self.minutes == Self::MINUTES;
        Ok(if over { Outcome::Truncated } else { Outcome::Running })
    }
}
