//! A robot as plain data: the one description from which every engine's model is built.

mod actuator;
mod body;
mod capsule;
mod check;
mod collision;
mod geom;
mod health;
mod joint;
mod kinematics;
mod mjcf;
mod noise;
mod observation;
mod part;
mod planar;
mod pose;
mod preset;
mod softness;
mod solver;
mod velocity_point;

mod ant;
mod halfcheetah;
mod hopper;
mod humanoid;
mod walker2d;

pub use actuator::Actuator;
pub use ant::ant;
pub use body::{Body, Inertial};
pub use capsule::Capsule;
pub use geom::{Geom, Shape};
pub use halfcheetah::halfcheetah;
pub use health::Health;
pub use hopper::hopper;
pub use humanoid::humanoid;
pub use joint::{Joint, JointKind};
pub use kinematics::Segment;
pub use noise::Noise;
pub use observation::{Observation, Senses};
pub use part::Part;
pub use pose::Pose;
pub use preset::Preset;
pub use softness::Softness;
pub use solver::{Algorithm, Integrator, Solver};
pub use velocity_point::VelocityPoint;
pub use walker2d::walker2d;

use crate::Dims;

/// A robot, the world it lives in, and the conventions of its environments: where it starts, when
/// it counts as healthy, what the agent sees of it and which point counts as its place.
///
/// Conventions are MuJoCo's: SI units and radians, z up, quaternions as (w, x, y, z), body frames
/// relative to the parent, the world as the parent of every body that has none. Bodies are listed
/// depth first (a body, then all below it, then the next), and joints in the order of qpos.
///
/// ```
/// use copq_envs::RobotSpec;
/// use copq_envs::robot::{
///     Actuator, Body, Capsule, Geom, Health, Integrator, Joint, Noise, Observation, Solver,
///     VelocityPoint,
/// };
///
/// // A rod of 1 m that hangs from a motor, 2 m above the ground.
/// let rod = Capsule::between([0.0; 3], [0.0, 0.0, -1.0], 0.05);
/// let pendulum = RobotSpec {
///     name: "pendulum".into(),
///     bodies: vec![Body::new("rod", None, [0.0, 0.0, 2.0], rod.solid(1000.0))],
///     joints: vec![Joint { damping: 0.1, ..Joint::hinge("pivot", 0, [0.0, 1.0, 0.0]) }],
///     geoms: vec![Geom::capsule("rod", 0, rod)],
///     actuators: vec![Actuator { joint: 0, gear: 10.0, range: [-1.0, 1.0] }],
///     gravity: [0.0, 0.0, -9.81],
///     timestep: 0.002,
///     integrator: Integrator::Rk4,
///     solver: Solver::MUJOCO,
///     frame_skip: 4,
///     initial_qpos: vec![0.0],
///     reset_noise: [Noise::Uniform(0.1); 2],
///     health: Health::Always,
///     velocity_point: VelocityPoint::X,
///     observation: Observation { skip: 0, ..Observation::planar() },
/// };
/// pendulum.check()?;
/// assert_eq!((pendulum.nq(), pendulum.nu(), pendulum.dt()), (1, 1, 0.008));
/// assert_eq!(pendulum.observation.len(&pendulum), 2); // angle and velocity
///
/// let error = RobotSpec { frame_skip: 0, ..pendulum }.check().unwrap_err();
/// assert_eq!(error.to_string(), "robot pendulum: frame_skip: wanted at least 1, got 0");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSpec {
    /// A short name such as `hopper`.
    pub name: String,
    /// The rigid bodies, depth first.
    pub bodies: Vec<Body>,
    /// The joints, in the order of qpos and of their bodies; a body with several joints applies
    /// them in order.
    pub joints: Vec<Joint>,
    /// The shapes that collide, including the floor.
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
    /// When an episode continues.
    pub health: Health,
    /// The point whose motion is the robot's velocity.
    pub velocity_point: VelocityPoint,
    /// What an agent sees.
    pub observation: Observation,
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

    /// The sizes of the model.
    pub fn dims(&self) -> Dims {
        Dims { nq: self.nq(), nv: self.nv(), nu: self.nu() }
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

    /// Scales the quaternions in a position to length 1 (quaternions of zeros stay).
    pub fn normalise(&self, qpos: &mut [f64]) {
        let mut rest = qpos;
        for joint in &self.joints {
            let (own, later) = rest.split_at_mut(joint.kind.nq());
            if joint.kind == JointKind::Free {
                let norm = own[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
                own[3..].iter_mut().filter(|_| norm > 0.0).for_each(|x| *x /= norm);
            }
            rest = later;
        }
    }

    /// The position that puts this robot's bodies where the other's are at its start. The two
    /// robots have the same joints, but the joints' references may differ.
    pub fn pose_of(&self, other: &Self) -> Vec<f64> {
        let shift =
            |(own, other): (&Joint, &Joint)| vec![own.reference - other.reference; own.kind.nq()];
        let shifts = self.joints.iter().zip(&other.joints).flat_map(shift);
        other.initial_qpos.iter().zip(shifts).map(|(position, shift)| position + shift).collect()
    }
}
