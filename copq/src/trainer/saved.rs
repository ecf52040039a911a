//! Saving and loading a trainer.

use super::Trainer;
use crate::{Agent, Result, State};

impl<A: Agent> Trainer<A> {
    /// Writes everything the rest of the run depends on, replacing what the state held. An error in
    /// the middle of an episode if the environment cannot be saved; see
    /// [`Trainer::save_without_episodes`].
    pub fn save(&self, state: &mut State) -> Result<()> {
        self.save_without_episodes(state)?;
        self.rollouts[0].save(state)?;
        for (i, rollout) in self.rollouts.iter().enumerate().skip(1) {
            rollout.save(state.child_mut(&format!("world.{i}")))?;
        }
        Ok(())
    }

    /// Writes the same except for the running episodes, for environments that cannot be saved. A
    /// trainer that resumes from this begins new episodes; all else is exact.
    pub fn save_without_episodes(&self, state: &mut State) -> Result<()> {
        *state = State::default();
        state.put("steps", [self.steps]);
        self.episode_seeds.save("episode_seeds", state);
        for i in 1..self.rollouts.len() {
            state.child_mut(&format!("world.{i}"));
        }
        self.agent.save(state.child_mut("agent"))
    }

    /// Restores what [`Trainer::save`] wrote; the next step is then the same, bit for bit. After an
    /// error the trainer is partly restored: make a new one.
    pub fn load(&mut self, state: &State) -> Result<()> {
        // The agent first: it checks that the state fits.
        self.agent.load(state.child("agent")?)?;
        self.steps = state.get_one("steps")?;
        self.episode_seeds.load("episode_seeds", state)?;
        self.rollouts[0].load(state)?;
        for (i, rollout) in self.rollouts.iter_mut().enumerate().skip(1) {
            rollout.load(state.child(&format!("world.{i}"))?)?;
        }
        Ok(())
    }
}
