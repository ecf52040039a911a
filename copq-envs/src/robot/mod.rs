//! A robot in plain data: the one description from which every engine's model is built.

mod actuator;
mod body;
mod check;
mod collision;
mod geom;
mod hopper;
mod joint;
mod kinematics;
mod mjcf;
mod noise;
mod pose;
mod softness;
mod solver;

pub use actuator::Actuator;
pub use body::{Body, Inertial};
pub use geom::{Geom, Shape};
pub use hopper::hopper;
pub use joint::{Joint, JointKind};
pub use kinematics::Segment;
pub use noise::Noise;
pub use pose::Pose;
pub use softness::Softness;
pub use solver::{Algorithm, Integrator, Solver};

/// A robot and the world it lives in.
///
/// Conventions are MuJoCo's: SI units and radians, z up, quaternions as (w, x, y, z), body frames relative to the parent,
/// the world as parent of everything that has none. Bodies come depth first (a body, then all below it, then the next), joints
/// in the order of qpos.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSpec {
    /// A short name such as `hopper`.
    pub name: String,
    /// The rigid bodies, depth first.
    pub bodies: Vec<Body>,
    /// The joints, in the order of qpos and of their bodies; a body with several joints applies them in order.
    pub joints: Vec<Joint>,
    /// The shapes that collide, the floor among them.
    pub geoms: Vec<Geom>,
    /// The motors, in the order of the controls.
    pub actuators: Vec<Actuator>,
    /// Gravity (m/s^2).
    pub gravity: [f64; 3],
    /// Length of a physics step (s).
    pub timestep: f64,
    /// How an engine advances time.
    pub integrator: Integrator,
    /// How it solves for the forces of contacts and limits.
    pub solver: Solver,
    /// Physics steps in one environment step.
    pub frame_skip: usize,
    /// The position at the start of an episode, before noise (length nq).
    pub initial_qpos: Vec<f64>,
    /// Noise added to every element of qpos and of qvel at a reset.
    pub reset_noise: [Noise; 2],
}

impl RobotSpec {
    /// Length of the generalised position qpos.
    pub fn nq(&self) -> usize {
        self.joints.iter().map(|joint| joint.kind.nq()).sum()
    }

    /// Length of the generalised velocity qvel.
    pub fn nv(&self) -> usize {
        self.joints.iter().map(|joint| joint.kind.nv()).sum()
    }

    /// Number of actuators.
    pub fn nu(&self) -> usize {
        self.actuators.len()
    }

    /// Length of an environment step (s).
    pub fn dt(&self) -> f64 {
        self.timestep * self.frame_skip as f64
    }

    /// Mass of all bodies (kg).
    pub fn total_mass(&self) -> f64 {
        self.bodies.iter().map(|body| body.inertial.mass).sum()
    }

    /// The joints of one body, in order, with their indices.
    pub fn joints_of(&self, body: usize) -> impl Iterator<Item = (usize, &Joint)> {
        self.joints.iter().enumerate().filter(move |(_, joint)| joint.body == body)
    }
}
