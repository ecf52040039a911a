//! An engine that plays a recorded run.

use copq::{Error, Result, State};
use copq_envs::{Dims, Field, Physics, RobotSpec};

use super::Table;

/// What an engine tells after one step.
#[derive(Clone, Debug)]
struct Frame {
    qpos: Vec<f64>,
    qvel: Vec<f64>,
    fields: Vec<(Field, Vec<f64>)>,
}

/// Plays recorded states, one per step, whatever the controls.
#[derive(Debug)]
pub struct Recording {
    dims: Dims,
    frames: Vec<Frame>,
    row: usize,
}

const FIELDS: [(Field, &str); 6] = [
    (Field::BodyPosition, "xpos"),
    (Field::BodyCentre, "xipos"),
    (Field::Inertia, "cinert"),
    (Field::Velocity, "cvel"),
    (Field::ActuatorForce, "qfrc"),
    (Field::ContactForce, "cfrc"),
];

impl Recording {
    pub fn new(robot: &RobotSpec, table: &Table) -> Self {
        let frames = (0..table.len()).map(|row| frame(table, row)).collect();
        Self { dims: robot.dims(), frames, row: 0 }
    }
}

fn frame(table: &Table, row: usize) -> Frame {
    let fields = FIELDS.map(|(field, name)| (field, table.vector(row, name)));
    let fields = fields.into_iter().filter(|(_, values)| !values.is_empty()).collect();
    Frame { qpos: table.vector(row, "qpos"), qvel: table.vector(row, "qvel"), fields }
}

impl Physics for Recording {
    fn name(&self) -> &str {
        "recording"
    }

    fn dims(&self) -> Dims {
        self.dims
    }

    fn reset_to(&mut self, _: &[f64], _: &[f64]) -> Result<()> {
        self.row = 0;
        Ok(())
    }

    fn step(&mut self, _: &[f64], _: usize) -> Result<()> {
        self.row += 1;
        let end = || Error::Env { env: "recording".into(), what: "is over".into() };
        if self.row < self.frames.len() { Ok(()) } else { Err(end()) }
    }

    fn qpos(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.frames[self.row].qpos);
    }

    fn qvel(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.frames[self.row].qvel);
    }

    fn read(&mut self, field: Field, out: &mut [f64]) -> Result<()> {
        let found = self.frames[self.row].fields.iter().find(|(known, _)| *known == field);
        let missing = || Error::Env { env: "recording".into(), what: format!("has no {field:?}") };
        out.copy_from_slice(&found.ok_or_else(missing)?.1);
        Ok(())
    }

    fn save(&self, _: &mut State) -> Result<()> {
        Ok(())
    }

    fn load(&mut self, _: &State) -> Result<()> {
        Ok(())
    }
}
