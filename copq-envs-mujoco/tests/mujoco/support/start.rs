//! An engine whose every reset goes to one state.

use copq::{Result, State};
use copq_envs::{Dims, Field, Physics};
use copq_envs_mujoco::Mujoco;

#[derive(Debug)]
pub struct Start {
    pub physics: Mujoco,
    pub qpos: Vec<f64>,
    pub qvel: Vec<f64>,
}

impl Physics for Start {
    fn name(&self) -> &str {
        self.physics.name()
    }

    fn dims(&self) -> Dims {
        self.physics.dims()
    }

    fn reset_to(&mut self, _: &[f64], _: &[f64]) -> Result<()> {
        self.physics.reset_to(&self.qpos, &self.qvel)
    }

    fn step(&mut self, ctrl: &[f64], substeps: usize) -> Result<()> {
        self.physics.step(ctrl, substeps)
    }

    fn qpos(&self, out: &mut [f64]) {
        self.physics.qpos(out);
    }

    fn qvel(&self, out: &mut [f64]) {
        self.physics.qvel(out);
    }

    fn read(&mut self, field: Field, out: &mut [f64]) -> Result<()> {
        self.physics.read(field, out)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.physics.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.physics.load(state)
    }
}
