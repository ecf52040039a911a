//! The engine: one robot in one rapier world.

use std::fmt;

use copq::error::check_len;
use copq::{Error, Result, State};
use copq_envs::robot::Actuator;
use copq_envs::{Dims, Physics, RobotSpec};
use rapier3d_f64::prelude::{MultibodyIndex, RigidBodyHandle};

use crate::assemble::Assembly;
use crate::coordinate::Coordinate;
use crate::engine::Engine;
use crate::world::World;

const NAME: &str = "rapier 0.36.1";

/// rapier 0.36.1 in double precision with multibody joints, as a [`Physics`].
///
/// A snapshot is the whole world, contact memory included, some tens of kilobytes; it replays bit for bit, in another
/// process of the same build too.
pub struct Rapier {
    robot: String,
    dims: Dims,
    pristine: World,
    world: World,
    engine: Engine,
    index: MultibodyIndex,
    coordinates: Vec<Coordinate>,
    actuators: Vec<Actuator>,
    bodies: Vec<RigidBodyHandle>,
    /// Coordinates of a reset, by rapier's freedom.
    displacement: Vec<f64>,
}

impl Rapier {
    /// Builds a world for a robot: chains of hinges below a planar root, so far.
    pub fn new(robot: &RobotSpec) -> Result<Self> {
        let assembly = Assembly::new(robot)?;
        let dims = Dims { nq: robot.nq(), nv: robot.nv(), nu: robot.nu() };
        Ok(Self {
            robot: robot.name.clone(),
            dims,
            pristine: assembly.world.clone(),
            world: assembly.world,
            engine: Engine::new(robot),
            index: assembly.robot,
            coordinates: assembly.coordinates,
            actuators: robot.actuators.clone(),
            bodies: assembly.bodies,
            displacement: vec![0.0; dims.nv],
        })
    }

    /// Sets the motors' torques for the next timestep.
    fn drive(&mut self, ctrl: &[f64]) {
        let (multibody, _) = self.world.split(self.index);
        for (actuator, ctrl) in self.actuators.iter().zip(ctrl) {
            let [low, high] = actuator.range;
            self.coordinates[actuator.joint].drive(multibody, actuator.gear * ctrl.clamp(low, high));
        }
    }

    /// rapier's own quarantine looks at bodies, this at the joints.
    fn is_finite(&self) -> bool {
        let multibody = self.world.multibody(self.index);
        let positions = self.coordinates.iter().map(|coordinate| coordinate.position(multibody));
        positions.chain(multibody.generalized_velocity().iter().copied()).all(f64::is_finite)
    }

    fn error(&self, what: impl Into<String>) -> Error {
        Error::Env { env: format!("{} on {NAME}", self.robot), what: what.into() }
    }
}

impl Physics for Rapier {
    fn name(&self) -> &str {
        NAME
    }

    fn dims(&self) -> Dims {
        self.dims
    }

    fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
        check_len("qpos", qpos.len(), self.dims.nq)?;
        check_len("qvel", qvel.len(), self.dims.nv)?;
        if !qpos.iter().chain(qvel).all(|value| value.is_finite()) {
            return Err(self.error(format!("reset to a state that is not finite: {qpos:?}, {qvel:?}")));
        }
        self.world = self.pristine.clone();
        self.engine.restart();
        let (multibody, bodies) = self.world.split(self.index);
        for ((coordinate, position), velocity) in self.coordinates.iter().zip(qpos).zip(qvel) {
            // The pristine coordinates are 0, so a displacement is a position.
            self.displacement[coordinate.dof] = position - coordinate.reference;
            multibody.generalized_velocity_mut()[coordinate.dof] = *velocity;
        }
        multibody.apply_displacements(&self.displacement);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
        Ok(())
    }

    fn step(&mut self, ctrl: &[f64], substeps: usize) -> Result<()> {
        check_len("ctrl", ctrl.len(), self.dims.nu)?;
        if !ctrl.iter().all(|value| value.is_finite()) {
            return Err(self.error(format!("a control is not finite: {ctrl:?}")));
        }
        for substep in 0..substeps {
            self.drive(ctrl);
            if !self.engine.step(&mut self.world) || !self.is_finite() {
                return Err(self.error(format!("the state stopped being finite in substep {substep}; reset first")));
            }
        }
        Ok(())
    }

    fn qpos(&self, out: &mut [f64]) {
        let multibody = self.world.multibody(self.index);
        out.iter_mut().zip(&self.coordinates).for_each(|(out, coordinate)| *out = coordinate.position(multibody));
    }

    fn qvel(&self, out: &mut [f64]) {
        let velocity = self.world.multibody(self.index).generalized_velocity();
        out.iter_mut().zip(&self.coordinates).for_each(|(out, coordinate)| *out = velocity[coordinate.dof]);
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("engine", NAME.as_bytes());
        state.put("robot", self.robot.as_bytes());
        state.put("world", self.world.to_bytes()?);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        for (key, wanted) in [("engine", NAME), ("robot", self.robot.as_str())] {
            let got = state.get::<u8>(key)?;
            if got != wanted.as_bytes() {
                return Err(Error::invalid(format!("{key} of a saved state"), wanted, String::from_utf8_lossy(got)));
            }
        }
        self.world = World::from_bytes(state.get("world")?)?;
        self.engine.restart();
        Ok(())
    }

    fn centre_of_mass(&self) -> Option<[f64; 3]> {
        let mut sum = [0.0; 3];
        let mut mass = 0.0;
        for body in self.bodies.iter().filter_map(|handle| self.world.bodies.get(*handle)) {
            mass += body.mass();
            let centre = body.center_of_mass().to_array();
            sum.iter_mut().zip(centre).for_each(|(sum, centre)| *sum += body.mass() * centre);
        }
        Some(sum.map(|moment| moment / mass))
    }

    fn mass_matrix(&self) -> Option<Vec<f64>> {
        let mut multibody = self.world.multibody(self.index).clone();
        // Its by-product is the factorisation of the mass matrix with armature, without damping or springs.
        multibody.dof_inverse_inertia(&self.world.bodies);
        let factors = multibody.inv_augmented_mass();
        let mut matrix = factors.l() * factors.u();
        factors.p().inv_permute_rows(&mut matrix);
        let at = |row: &Coordinate, column: &Coordinate| matrix[(row.dof, column.dof)];
        let rows = self.coordinates.iter();
        Some(rows.flat_map(|row| self.coordinates.iter().map(move |column| at(row, column))).collect())
    }
}

impl fmt::Debug for Rapier {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Rapier")
            .field("robot", &self.robot)
            .field("dims", &self.dims)
            .field("timestep", &self.engine.timestep())
            .finish_non_exhaustive()
    }
}
