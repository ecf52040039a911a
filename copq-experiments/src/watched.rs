//! An environment that answers a signal: long evaluations end when somebody asks.

use copq::{Env, EnvSpec, Error, Outcome, Result};

use crate::stop::Stop;

/// An environment whose next step is an error once a signal has come.
pub(crate) struct Watched<'a> {
    pub env: &'a mut dyn Env,
    pub stop: &'a Stop,
}

impl Env for Watched<'_> {
    fn spec(&self) -> &EnvSpec {
        self.env.spec()
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.env.reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        if self.stop.is_asked() {
            return Err(Error::Unsupported { what: "stopped by a signal".to_owned() });
        }
        self.env.step(action, obs, reward)
    }
}
