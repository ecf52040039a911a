//! Controls in, generalised forces out.

use copq::{Result, State};
use copq_envs::RobotSpec;
use copq_envs::robot::Actuator;
use rapier3d_f64::prelude::Multibody;

use crate::coordinate::{Coordinate, Place};
use crate::scalar_joint::Axis;

/// The motors and springs of a robot.
pub(crate) struct Motors {
    actuators: Vec<Actuator>,
    /// The motors' force on each joint (N or N m), in the order of the joints.
    forces: Vec<f64>,
    /// The joints with a motor or a spring.
    driven: Vec<(usize, Axis)>,
}

impl Motors {
    pub(crate) fn new(robot: &RobotSpec, coordinates: &[Coordinate]) -> Self {
        let driven = coordinates.iter().enumerate().filter_map(|(joint, coordinate)| {
            let Place::Axis(axis) = &coordinate.joint else { return None };
            let motor = robot.actuators.iter().any(|actuator| actuator.joint == joint);
            (motor || axis.stiffness > 0.0).then(|| (joint, axis.clone()))
        });
        Self {
            actuators: robot.actuators.clone(),
            forces: vec![0.0; robot.joints.len()],
            driven: driven.collect(),
        }
    }

    /// Sets the controls; several motors on one joint add up.
    pub(crate) fn set(&mut self, ctrl: &[f64]) {
        self.forces.fill(0.0);
        for (actuator, ctrl) in self.actuators.iter().zip(ctrl) {
            let [low, high] = actuator.range;
            self.forces[actuator.joint] += actuator.gear * ctrl.clamp(low, high);
        }
    }

    /// Hands forces and springs to rapier for the next timestep.
    pub(crate) fn drive(&self, multibody: &mut Multibody) {
        self.driven.iter().for_each(|(joint, axis)| axis.drive(multibody, self.forces[*joint]));
    }

    /// Writes the motors' generalised force, in the order of qvel.
    pub(crate) fn write(&self, coordinates: &[Coordinate], out: &mut [f64]) {
        for (coordinate, force) in coordinates.iter().zip(&self.forces) {
            out[coordinate.qvel.clone()].fill(*force);
        }
    }

    pub(crate) fn save(&self, state: &mut State) {
        state.put("forces", self.forces.clone());
    }

    pub(crate) fn load(&mut self, state: &State) -> Result<()> {
        state.read("forces", &mut self.forces)
    }
}
