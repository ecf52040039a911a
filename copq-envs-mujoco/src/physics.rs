//! The engine: one robot in one MuJoCo simulation.

use std::cell::{Cell, RefCell};
use std::fmt;

use copq::error::check_len;
use copq::{Error, Result, State};
use copq_envs::{Dims, Field, Identity, Physics, RobotSpec};

use crate::simulation::{Array, Call, Simulation};
use crate::version::dotted;

/// C MuJoCo as a [`Physics`].
///
/// A step costs what MuJoCo's own calls cost and allocates nothing; contact forces are computed
/// when they are read. A state that MuJoCo would silently reset (not finite, or beyond 1e10) is an
/// error, and so is everything else that it warns about. After an error the simulation must be
/// reset. A snapshot is MuJoCo's integration state and the readable fields: a few kilobytes that
/// replay bit for bit.
pub struct Mujoco {
    identity: Identity,
    masses: Vec<f64>,
    /// Damping that MuJoCo does not apply itself, by degree of freedom.
    damping: Option<Vec<f64>>,
    // Cells, because a snapshot may have to compute contact forces first.
    simulation: RefCell<Box<dyn Simulation>>,
    /// Whether cfrc_ext is older than the state.
    forces_are_old: Cell<bool>,
    /// Whether an error left the data in a state that cannot be continued.
    broken: bool,
}

impl Mujoco {
    /// Compiles a robot for this version of MuJoCo with `open`, which takes MJCF.
    pub(crate) fn new(
        robot: &RobotSpec,
        version: i32,
        open: fn(&str) -> Result<Box<dyn Simulation>>,
    ) -> Result<Self> {
        robot.check()?;
        let mjcf = robot.mjcf(version);
        let mut engine = Self {
            identity: Identity::new(format!("MuJoCo {}", dotted(version)), robot),
            masses: robot.bodies.iter().map(|body| body.inertial.mass).collect(),
            damping: robot.applied_damping(version),
            simulation: RefCell::new(open(&mjcf)?),
            forces_are_old: Cell::new(false),
            broken: false,
        };
        engine.reset_to(&robot.initial_qpos, &vec![0.0; robot.nv()])?;
        Ok(engine)
    }

    /// A second simulation, evaluated where this one is now: after a step the data's fields lag
    /// behind the state.
    fn evaluated(&self) -> Result<Box<dyn Simulation>, String> {
        let simulation = self.simulation.borrow();
        let mut fork = simulation.fork()?;
        place(&mut *fork, simulation.array(Array::Qpos), simulation.array(Array::Qvel))?;
        Ok(fork)
    }

    fn update_contact_forces(&self) -> Result<()> {
        // A simulation that cannot continue has none: MuJoCo may only reset it.
        if !self.broken && self.forces_are_old.replace(false) {
            let done = self.simulation.borrow_mut().call(Call::ContactForce, 1);
            done.map_err(|what| self.identity.error(what))?;
        }
        Ok(())
    }

    /// The error of a simulation that cannot continue.
    fn failure(&mut self, what: String) -> Error {
        self.broken = true;
        self.identity.error(format!("{what}; reset first"))
    }
}

impl Physics for Mujoco {
    fn name(&self) -> &str {
        self.identity.engine()
    }

    fn dims(&self) -> Dims {
        self.identity.dims()
    }

    fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
        self.identity.check_state(qpos, qvel)?;
        place(&mut **self.simulation.get_mut(), qpos, qvel).map_err(|what| self.failure(what))?;
        // As in Gymnasium, contact forces are 0 until the first step.
        self.forces_are_old.set(false);
        self.broken = false;
        Ok(())
    }

    fn step(&mut self, ctrl: &[f64], substeps: usize) -> Result<()> {
        if self.broken {
            return Err(self.identity.error("step after an error; reset first"));
        }
        self.identity.check_ctrl(ctrl)?;
        self.forces_are_old.set(true);
        let simulation = &mut **self.simulation.get_mut();
        advance(simulation, self.damping.as_deref(), ctrl, substeps)
            .map_err(|what| self.failure(what))
    }

    fn qpos(&self, out: &mut [f64]) {
        out.copy_from_slice(self.simulation.borrow().array(Array::Qpos));
    }

    fn qvel(&self, out: &mut [f64]) {
        out.copy_from_slice(self.simulation.borrow().array(Array::Qvel));
    }

    fn read(&mut self, field: Field, out: &mut [f64]) -> Result<()> {
        if field == Field::ContactForce {
            self.update_contact_forces()?;
        }
        let (array, world) = match field {
            Field::BodyPosition => (Array::Xpos, 3),
            Field::BodyCentre => (Array::Xipos, 3),
            Field::Inertia => (Array::Cinert, 10),
            Field::Velocity => (Array::Cvel, 6),
            Field::ActuatorForce => (Array::QfrcActuator, 0),
            Field::ContactForce => (Array::CfrcExt, 6),
        };
        let values = &self.simulation.get_mut().array(array)[world..];
        check_len("buffer of a field", out.len(), values.len())?;
        out.copy_from_slice(values);
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.update_contact_forces()?;
        self.identity.save(state);
        state.put("broken", [u64::from(self.broken)]);
        let simulation = self.simulation.borrow();
        Array::SAVED.iter().for_each(|(array, name)| state.put(name, simulation.array(*array)));
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.identity.check(state)?;
        let broken = state.get_one::<u64>("broken")? != 0;
        self.broken = true;
        let simulation = self.simulation.get_mut();
        let reset = simulation.call(Call::Reset, 1);
        Array::SAVED
            .iter()
            .try_for_each(|(array, name)| state.read(name, simulation.array_mut(*array)))?;
        reset.map_err(|what| self.failure(what))?;
        self.forces_are_old.set(false);
        self.broken = broken;
        Ok(())
    }

    fn centre_of_mass(&self) -> Option<[f64; 3]> {
        let simulation = self.evaluated().ok()?;
        let mut sum = [0.0; 3];
        for (mass, centre) in self.masses.iter().zip(simulation.array(Array::Xipos)[3..].chunks(3))
        {
            sum.iter_mut().zip(centre).for_each(|(sum, centre)| *sum += mass * centre);
        }
        Some(sum.map(|moment| moment / self.masses.iter().sum::<f64>()))
    }

    fn mass_matrix(&self) -> Option<Vec<f64>> {
        Some(self.evaluated().ok()?.mass_matrix())
    }
}

impl fmt::Debug for Mujoco {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Mujoco").field("identity", &self.identity).finish_non_exhaustive()
    }
}

/// Resets the data, sets a state and evaluates the model there.
fn place(simulation: &mut dyn Simulation, qpos: &[f64], qvel: &[f64]) -> Result<(), String> {
    simulation.call(Call::Reset, 1)?;
    simulation.array_mut(Array::Qpos).copy_from_slice(qpos);
    simulation.array_mut(Array::Qvel).copy_from_slice(qvel);
    simulation.call(Call::Forward, 1)?;
    complaint(simulation).map_or(Ok(()), Err)
}

/// Takes timesteps with the controls held, and with the damping that MuJoCo leaves to us.
fn advance(
    simulation: &mut dyn Simulation,
    damping: Option<&[f64]>,
    ctrl: &[f64],
    substeps: usize,
) -> Result<(), String> {
    simulation.array_mut(Array::Ctrl).copy_from_slice(ctrl);
    match damping {
        None => simulation.call(Call::Step, substeps)?,
        Some(damping) => (0..substeps).try_for_each(|_| {
            damp(simulation, damping);
            simulation.call(Call::Step, 1)
        })?,
    }
    complaint(simulation).map_or(Ok(()), Err)
}

/// Applies damping at the current velocity.
fn damp(simulation: &mut dyn Simulation, damping: &[f64]) {
    for (freedom, damping) in damping.iter().enumerate() {
        let velocity = simulation.array(Array::Qvel)[freedom];
        simulation.array_mut(Array::Applied)[freedom] = -damping * velocity;
    }
}

/// What is wrong with a simulation. MuJoCo resets states that it calls bad and continues; only its
/// warning remains.
fn complaint(simulation: &dyn Simulation) -> Option<String> {
    let state = simulation.array(Array::Qpos).iter().chain(simulation.array(Array::Qvel));
    let finite = state.copied().all(f64::is_finite);
    simulation.warning().or_else(|| (!finite).then(|| "the state stopped being finite".into()))
}
