//! rapier's pipeline with the settings that were measured to behave like MuJoCo.

use copq_envs::RobotSpec;
use rapier3d_f64::prelude::{
    CCDSolver, ImpulseJointSet, IntegrationParameters, PhysicsPipeline, Real, SoftBodySet, Vector,
};

use crate::condim::Condim;
use crate::softness::contact_spring;
use crate::world::World;

/// What steps a [`World`]: settings, buffers, and the kinds of thing that robots have none of.
pub(crate) struct Engine {
    pipeline: PhysicsPipeline,
    parameters: IntegrationParameters,
    gravity: Vector,
    impulse_joints: ImpulseJointSet,
    soft_bodies: SoftBodySet,
    ccd: CCDSolver,
}

impl Engine {
    pub(crate) fn new(robot: &RobotSpec) -> Self {
        Self {
            pipeline: PhysicsPipeline::new(),
            parameters: parameters(robot),
            gravity: Vector::from_array(robot.gravity),
            impulse_joints: ImpulseJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            ccd: CCDSolver::new(),
        }
    }

    /// Length of a step (s).
    pub(crate) fn timestep(&self) -> Real {
        self.parameters.dt
    }

    /// Forgets buffers that belong to another world.
    pub(crate) fn restart(&mut self) {
        self.pipeline = PhysicsPipeline::new();
        self.ccd = CCDSolver::new();
    }

    /// One timestep; false if rapier had to quarantine something that is not finite.
    pub(crate) fn step(&mut self, world: &mut World) -> bool {
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
            &Condim,
            &(),
        );
        self.pipeline.quarantine().is_empty()
    }
}

/// One solver iteration is one substep here: four would cost three times as much. Without the stabilisation pass the
/// ant is thrown into the air. Continuous collision detection would stop links halfway through a step.
fn parameters(robot: &RobotSpec) -> IntegrationParameters {
    let spring = contact_spring(robot);
    IntegrationParameters {
        dt: robot.timestep,
        num_solver_iterations: 1,
        num_internal_stabilization_iterations: 1,
        max_ccd_substeps: 0,
        contact_softness: spring,
        static_contact_softness: spring,
        ..IntegrationParameters::default()
    }
}
