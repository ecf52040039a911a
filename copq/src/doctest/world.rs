// Hidden in this crate's examples: three steps of time, each worth 0.5, whatever the action.

use copq::*;

pub struct World {
    spec: EnvSpec,
    time: u8,
}

impl World {
    pub fn new() -> Self {
        Self { spec: EnvSpec::new("world", 1, 1).reward("time", 1.0).horizon(3), time: 0 }
    }
}

#[allow(dead_code)]
impl World {
    /// Time as a cost whose limit is 1, and as a reward.
    pub fn with_cost() -> Self {
        let spec = EnvSpec::new("world", 1, 1).cost("time", 1.0).reward("rest", 1.0).horizon(3);
        Self { spec, time: 0 }
    }
}

impl Env for World {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
        self.time = 0;
        obs[0] = 0.0;
        Ok(())
    }

    fn step(&mut self, _: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.time += 1;
        obs[0] = self.time.into();
        reward.fill(0.5);
        Ok(if self.time < 3 { Outcome::Running } else { Outcome::Truncated })
    }
}
