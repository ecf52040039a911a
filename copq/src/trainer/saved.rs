//! A trainer on disk and back.

use super::Trainer;
use crate::{Agent, Result, State};

impl<A: Agent> Trainer<A> {
    /// Writes everything the rest of the run depends on, in place of what the state held. An error
    /// in mid-episode of an environment that cannot be saved; see
    /// [`Trainer::save_without_episodes`].
    pub fn save(&self, state: &mut State) -> Result<()> {
        self.save_without_episodes(state)?;
        self.worlds[0].save(state)?;
        for (i, world) in self.worlds.iter().enumerate().skip(1) {
            world.save(state.child_mut(&format!("world.{i}")))?;
        }
        Ok(())
    }

    /// Writes the same but for the episodes that run, for worlds that cannot be saved: whoever goes
    /// on from it begins new ones, and all else is exact.
    pub fn save_without_episodes(&self, state: &mut State) -> Result<()> {
        *state = State::default();
        state.put("steps", [self.steps]);
        self.episode_seeds.save("episode_seeds", state);
        for i in 1..self.worlds.len() {
            state.child_mut(&format!("world.{i}"));
        }
        self.agent.save(state.child_mut("agent"))
    }

    /// Goes back to what [`Trainer::save`] wrote; the next step is then the same, bit for bit.
    /// After an error the trainer is partly restored: make a new one.
    pub fn load(&mut self, state: &State) -> Result<()> {
        // The agent first: it knows what the state is of.
        self.agent.load(state.child("agent")?)?;
        self.steps = state.get_one("steps")?;
        self.episode_seeds.load("episode_seeds", state)?;
        self.worlds[0].load(state)?;
        for (i, world) in self.worlds.iter_mut().enumerate().skip(1) {
            world.load(state.child(&format!("world.{i}"))?)?;
        }
        Ok(())
    }
}
