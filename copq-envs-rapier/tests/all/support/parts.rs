//! Small robots for single questions.

use copq_envs::RobotSpec;
use copq_envs::robot::{
    Actuator, Body, Geom, Health, Inertial, Joint, Noise, Observation, Preset, Shape,
    VelocityPoint, hopper,
};

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// A robot of these parts, without floor, 500 timesteps a second.
pub fn contraption(bodies: Vec<Body>, joints: Vec<Joint>) -> RobotSpec {
    let mut robot = RobotSpec {
        name: "contraption".into(),
        bodies,
        joints,
        geoms: Vec::new(),
        actuators: Vec::new(),
        initial_qpos: Vec::new(),
        reset_noise: [Noise::Uniform(0.0); 2],
        health: Health::Always,
        velocity_point: VelocityPoint::Body(0),
        observation: Observation { skip: 0, ..Observation::planar() },
        ..hopper(Preset::GymV5)
    };
    robot.initial_qpos = vec![0.0; robot.nq()];
    robot
}

/// A body of 2 kg, with moments of inertia 0.1, 0.2 and 0.25 kg m^2 about its origin.
pub fn block(name: &str, parent: Option<usize>) -> Body {
    let inertial = Inertial { mass: 2.0, com: [0.0; 3], moments: [0.1, 0.2, 0.25], quat: UPRIGHT };
    Body { name: name.into(), parent, pos: [0.0; 3], quat: UPRIGHT, inertial }
}

/// A body of 2 kg, its centre of mass off its origin, its frame turned and off its parent's.
pub fn crooked(name: &str, parent: Option<usize>) -> Body {
    let mut body = block(name, parent);
    (body.pos, body.quat) = ([0.3, -0.2, 0.1], [0.8, 0.0, 0.36, 0.48]);
    (body.inertial.com, body.inertial.quat) = ([0.05, 0.1, -0.2], [0.6, 0.8, 0.0, 0.0]);
    body
}

/// A ball of this radius (m) on a body, friction 1, without margin, which touches everything.
pub fn ball(body: Option<usize>, radius: f64) -> Geom {
    let floor = hopper(Preset::GymV5).geoms[0].clone();
    Geom { name: String::new(), body, shape: Shape::Sphere { radius }, margin: 0.0, ..floor }
}

/// A floor at this height (m), which touches everything.
pub fn floor(height: f64) -> Geom {
    Geom { name: "floor".into(), shape: Shape::Plane, pos: [0.0, 0.0, height], ..ball(None, 0.0) }
}

pub fn motor(joint: usize, gear: f64) -> Actuator {
    Actuator { joint, gear, range: [-1.0, 1.0] }
}
