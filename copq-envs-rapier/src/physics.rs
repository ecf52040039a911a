//! The engine: one robot in one rapier world.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use copq::{Result, State};
use copq_envs::{Dims, Field, Identity, Physics, RobotSpec};
use rapier3d_f64::na::DMatrix;
use rapier3d_f64::prelude::MultibodyIndex;

use crate::assemble::Assembly;
use crate::coordinate::Coordinate;
use crate::fields::{Fields, View};
use crate::limits::Limits;
use crate::motors::Motors;
use crate::pipeline::Pipeline;
use crate::world::World;

const NAME: &str = "rapier 0.36.1";

/// rapier 0.36.1 in double precision with multibody joints, as a [`Physics`].
///
/// A snapshot is the whole world, including contact memory: some tens of kilobytes. It replays bit
/// for bit, even in another process of the same build. Fields describe the state after the step;
/// contact forces are those of its last timestep.
///
/// ```
/// use copq::State;
/// use copq_envs::Physics;
/// use copq_envs_rapier::Rapier;
///
/// let hopper = copq_envs::task("a/hopper")?.robot;
/// let mut physics = Rapier::new(&hopper)?;
/// physics.reset_to(&hopper.initial_qpos, &[0.0; 6])?;
/// physics.step(&[0.0; 3], 20)?;
///
/// let mut snapshot = State::default();
/// physics.save(&mut snapshot)?;
/// let mut first = [0.0; 6];
/// physics.step(&[0.5, -0.5, 0.1], 20)?;
/// physics.qpos(&mut first);
///
/// let mut second = [0.0; 6];
/// physics.load(&snapshot)?;
/// physics.step(&[0.5, -0.5, 0.1], 20)?;
/// physics.qpos(&mut second);
/// assert_eq!(first, second);
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Rapier {
    identity: Identity,
    pristine: World,
    world: World,
    pipeline: Pipeline,
    index: MultibodyIndex,
    coordinates: Vec<Coordinate>,
    motors: Motors,
    limits: Limits,
    fields: Fields,
    /// Space for one number per degree of freedom.
    scratch: Vec<f64>,
}

impl Rapier {
    /// Builds a world for a robot.
    pub fn new(robot: &RobotSpec) -> Result<Self> {
        let Assembly { world, robot: index, coordinates, welds, links } = Assembly::new(robot)?;
        Ok(Self {
            identity: Identity::new(NAME, robot),
            pristine: world.clone(),
            world,
            pipeline: Pipeline::new(robot),
            index,
            motors: Motors::new(robot, &coordinates),
            limits: Limits::new(robot, &coordinates),
            coordinates,
            fields: Fields::new(robot, &welds, &links),
            scratch: vec![0.0; robot.nv()],
        })
    }

    /// rapier's own quarantine checks the bodies; this checks the joints.
    fn is_finite(&self) -> bool {
        let multibody = self.world.multibody(self.index);
        let positions = multibody.links().flat_map(|link| link.joint.coords());
        positions.chain(multibody.generalized_velocity().iter().copied()).all(f64::is_finite)
    }

    /// The velocities of rapier's degrees of freedom (rows) for unit velocities in qvel (columns),
    /// at the current position.
    fn basis(&self) -> DMatrix<f64> {
        let Dims { nq, nv, .. } = self.dims();
        let mut qpos = vec![0.0; nq];
        self.qpos(&mut qpos);
        let mut basis = DMatrix::zeros(nv, nv);
        for (unit, mut column) in basis.column_iter_mut().enumerate() {
            let mut qvel = vec![0.0; nv];
            qvel[unit] = 1.0;
            self.coordinates
                .iter()
                .for_each(|coordinate| coordinate.freedoms(&qpos, &qvel, column.as_mut_slice()));
        }
        basis
    }

    /// The mass matrix in rapier's degrees of freedom, with armature, without damping or springs.
    fn freedom_mass(&self) -> DMatrix<f64> {
        let mut multibody = self.world.multibody(self.index).clone();
        // Its by-product is the factorisation that we need.
        multibody.dof_inverse_inertia(&self.world.bodies);
        let factors = multibody.inv_augmented_mass();
        let mut matrix = factors.l() * factors.u();
        factors.p().inv_permute_rows(&mut matrix);
        matrix
    }
}

impl Physics for Rapier {
    fn name(&self) -> &str {
        NAME
    }

    fn dims(&self) -> Dims {
        self.identity.dims()
    }

    fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
        self.identity.check_state(qpos, qvel)?;
        self.world = self.pristine.clone();
        self.pipeline.restart();
        self.motors.set(&[]);
        let (multibody, bodies) = self.world.split(self.index);
        self.coordinates
            .iter()
            .for_each(|coordinate| coordinate.displacement(qpos, &mut self.scratch));
        multibody.apply_displacements(&self.scratch);
        self.coordinates
            .iter()
            .for_each(|coordinate| coordinate.freedoms(qpos, qvel, &mut self.scratch));
        multibody.generalized_velocity_mut().copy_from_slice(&self.scratch);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
        Ok(())
    }

    fn step(&mut self, ctrl: &[f64], substeps: usize) -> Result<()> {
        self.identity.check_ctrl(ctrl)?;
        self.motors.set(ctrl);
        for substep in 0..substeps {
            let (multibody, _) = self.world.split(self.index);
            self.motors.drive(multibody);
            self.limits.apply(multibody);
            if !self.pipeline.step(&mut self.world, self.index) || !self.is_finite() {
                return Err(self.identity.error(format!(
                    "the state stopped being finite in substep {substep}; reset first"
                )));
            }
        }
        Ok(())
    }

    fn qpos(&self, out: &mut [f64]) {
        let multibody = self.world.multibody(self.index);
        self.coordinates.iter().for_each(|coordinate| coordinate.position(multibody, out));
    }

    fn qvel(&self, out: &mut [f64]) {
        let multibody = self.world.multibody(self.index);
        self.coordinates.iter().for_each(|coordinate| coordinate.velocity(multibody, out));
    }

    fn read(&mut self, field: Field, out: &mut [f64]) -> Result<()> {
        let view = View { world: &self.world, robot: self.index };
        match field {
            Field::BodyPosition => self.fields.positions(view, out),
            Field::BodyCentre => self.fields.centres(view, out),
            Field::Inertia => self.fields.inertias(view, out),
            Field::Velocity => self.fields.velocities(view, out),
            Field::ActuatorForce => self.motors.write(&self.coordinates, out),
            Field::ContactForce => self.fields.contact_forces(view, self.pipeline.timestep(), out),
        }
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.identity.save(state);
        state.put("world", self.world.to_bytes()?);
        self.motors.save(state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.identity.check(state)?;
        let bytes: &[u8] = state.get("world")?;
        // rapier trusts its indices, so a world written by something else may make it panic. A copy
        // of it takes a step first; the restart discards what that leaves in the pipeline.
        let pipeline = &mut self.pipeline;
        let index = self.index;
        let tried = catch_unwind(AssertUnwindSafe(|| {
            let mut copy = World::from_bytes(bytes)?;
            copy.multibody(index);
            pipeline.step(&mut copy, index);
            World::from_bytes(bytes)
        }));
        self.pipeline.restart();
        let damaged = || self.identity.error("the saved state is damaged: rapier cannot step it");
        let world = tried.map_err(|_| damaged())??;
        self.motors.load(state)?;
        self.world = world;
        Ok(())
    }

    fn centre_of_mass(&self) -> Option<[f64; 3]> {
        Some(self.fields.centre_of_mass(View { world: &self.world, robot: self.index }).to_array())
    }

    fn mass_matrix(&self) -> Option<Vec<f64>> {
        let n = self.dims().nv;
        let basis = self.basis();
        let matrix = basis.transpose() * self.freedom_mass() * basis;
        Some((0..n * n).map(|i| matrix[(i / n, i % n)]).collect())
    }
}

impl fmt::Debug for Rapier {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Rapier")
            .field("identity", &self.identity)
            .field("timestep", &self.pipeline.timestep())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use copq::Rng;
    use copq_envs::robot::{self, Preset};

    use super::*;

    /// How deep the deepest contact of the last timestep was (m).
    fn depth(physics: &Rapier) -> f64 {
        let manifolds =
            physics.world.narrow_phase.contact_pairs().flat_map(|pair| pair.solver_manifolds());
        manifolds
            .flat_map(|manifold| &manifold.points)
            .fold(0.0, |depth, contact| f64::max(depth, -contact.dist))
    }

    /// Random motors throw the walker in by 7 cm, the others by less.
    #[test]
    fn limbs_do_not_sink_into_the_floor() {
        for robot in
            [robot::hopper, robot::walker2d, robot::halfcheetah, robot::ant, robot::humanoid]
        {
            let spec = robot(Preset::GymV5);
            let mut physics = Rapier::new(&spec).unwrap();
            let mut rng = Rng::with_stream(1, 95);
            physics.reset_to(&spec.initial_qpos, &vec![0.0; spec.nv()]).unwrap();
            for _ in 0..100 {
                let motors = spec.actuators.iter();
                let ctrl: Vec<_> =
                    motors.map(|motor| rng.uniform_in(motor.range[0], motor.range[1])).collect();
                for _ in 0..spec.frame_skip {
                    physics.step(&ctrl, 1).unwrap();
                    assert!(depth(&physics) < 0.1, "{}: {} m", spec.name, depth(&physics));
                }
            }
        }
    }
}
