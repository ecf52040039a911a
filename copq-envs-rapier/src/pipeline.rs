//! rapier's pipeline with the settings that were measured to behave like MuJoCo.

use copq_envs::RobotSpec;
use rapier3d_f64::prelude::{
    CCDSolver, ImpulseJointSet, IntegrationParameters, MultibodyIndex, PhysicsPipeline,
    SoftBodySet, Vector,
};

use crate::contact::Contacts;
use crate::soft_constraint::spring;
use crate::world::World;

/// What steps a [`World`]: settings, buffers, and the kinds of object that robots do not have.
pub(crate) struct Pipeline {
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    gravity: Vector,
    impulse_joints: ImpulseJointSet,
    soft_bodies: SoftBodySet,
    ccd: CCDSolver,
    contacts: Contacts,
}

impl Pipeline {
    pub(crate) fn new(robot: &RobotSpec) -> Self {
        let contacts = Contacts::new(robot);
        Self {
            pipeline: PhysicsPipeline::new(),
            parameters: parameters(robot.timestep, contacts.share()),
            gravity: Vector::from_array(robot.gravity),
            impulse_joints: ImpulseJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            ccd: CCDSolver::new(),
            contacts,
        }
    }

    /// Length of a step (s).
    pub(crate) fn timestep(&self) -> f64 {
        self.parameters.dt
    }

    /// Forgets buffers that belong to another world.
    pub(crate) fn restart(&mut self) {
        self.pipeline = PhysicsPipeline::new();
        self.ccd = CCDSolver::new();
    }

    /// One timestep; false if rapier had to quarantine something that is not finite.
    pub(crate) fn step(&mut self, world: &mut World, robot: MultibodyIndex) -> bool {
        self.contacts.watch(world.multibody(robot), &world.bodies);
        self.pipeline.step(
            self.gravity,
            &self.parameters,
            &mut world.islands,
            &mut world.broad_phase,
            &mut world.narrow_phase,
            &mut world.bodies,
            &mut world.colliders,
            &mut self.impulse_joints,
            &mut world.joints,
            &mut self.soft_bodies,
            &mut self.ccd,
            &self.contacts,
            &(),
        );
        self.pipeline.quarantine().is_empty()
    }
}

/// Contacts and limits get target velocities, which rapier must neither clamp nor take back
/// afterwards, as its stabilisation would. None acts before it is touched. One solver iteration is
/// one substep here; four would cost three times as much. Continuous collision detection would stop
/// links halfway through a step.
fn parameters(dt: f64, share: f64) -> IntegrationParameters {
    let spring = spring(share, dt);
    IntegrationParameters {
        dt,
        num_solver_iterations: 1,
        num_internal_pgs_iterations: 4,
        num_internal_stabilization_iterations: 0,
        normalized_max_corrective_velocity: f64::MAX,
        normalized_prediction_distance: 0.0,
        max_ccd_substeps: 0,
        contact_softness: spring,
        static_contact_softness: spring,
        ..IntegrationParameters::default()
    }
}
