//! An engine that does next to nothing.

use copq::{Error, Result, State};
use copq_envs::{Dims, Field, Physics, RobotSpec};

pub const HOPPER: Dims = Dims { nq: 6, nv: 6, nu: 3 };

/// Stands where it was put, with x growing by the first control in every substep; fails or goes NaN
/// when told to.
#[derive(Clone, Debug)]
pub struct Still {
    pub dims: Dims,
    pub qpos: Vec<f64>,
    pub qvel: Vec<f64>,
    /// The controls of the last step.
    pub ctrl: Vec<f64>,
    /// Steps until the state becomes this much lower (m), NaN for a broken engine.
    pub fall: Option<(usize, f64)>,
    /// The fields that it tells, all of them 0.
    pub tells: Vec<Field>,
    /// The fields that it was asked for.
    pub asked: Vec<Field>,
}

impl Still {
    pub fn new() -> Self {
        Self::with(HOPPER)
    }

    /// For any robot; it tells where bodies are.
    pub fn of(robot: &RobotSpec) -> Self {
        let dims = robot.dims();
        Self { tells: vec![Field::BodyPosition, Field::BodyCentre], ..Self::with(dims) }
    }

    fn with(dims: Dims) -> Self {
        let qpos = vec![0.0; dims.nq];
        let qvel = vec![0.0; dims.nv];
        let ctrl = vec![0.0; dims.nu];
        Self { dims, qpos, qvel, ctrl, fall: None, tells: Vec::new(), asked: Vec::new() }
    }

    pub fn falling(after: usize, by: f64) -> Self {
        Self { fall: Some((after, by)), ..Self::new() }
    }
}

impl Physics for Still {
    fn name(&self) -> &str {
        "still"
    }

    fn dims(&self) -> Dims {
        self.dims
    }

    fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
        (self.qpos, self.qvel) = (qpos.to_vec(), qvel.to_vec());
        Ok(())
    }

    fn step(&mut self, ctrl: &[f64], substeps: usize) -> Result<()> {
        self.ctrl = ctrl.to_vec();
        self.qpos[0] += ctrl[0] * substeps as f64;
        if let Some((after, by)) = &mut self.fall {
            *after -= 1;
            if *after == 0 {
                self.qpos[1] -= *by;
            }
        }
        Ok(())
    }

    fn qpos(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.qpos);
    }

    fn qvel(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.qvel);
    }

    fn read(&mut self, field: Field, out: &mut [f64]) -> Result<()> {
        self.asked.push(field);
        if self.tells.contains(&field) {
            out.fill(0.0);
            return Ok(());
        }
        Err(Error::Env {
            env: "still".into(),
            what: format!("this engine does not tell {field:?}"),
        })
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("qpos", self.qpos.clone());
        state.put("qvel", self.qvel.clone());
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("qpos", &mut self.qpos)?;
        state.read("qvel", &mut self.qvel)
    }
}
