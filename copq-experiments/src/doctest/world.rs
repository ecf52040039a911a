// Hidden in this crate's examples: an environment whose episodes of three steps return 1.5.

use copq::*;

pub struct World(pub EnvSpec, pub u8);

impl Env for World {
    fn spec(&self) -> &EnvSpec {
        &self.0
    }

    fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
        self.1 = 0;
        obs[0] = 0.0;
        Ok(())
    }

    fn step(&mut self, _: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.1 += 1;
        obs[0] = self.1.into();
        reward[0] = 0.5;
        Ok(if self.1 < 3 { Outcome::Running } else { Outcome::Truncated })
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("step", [self.1]);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.1 = state.get_one("step")?;
        Ok(())
    }
}
