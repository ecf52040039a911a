//! The humanoid: a torso on a waist of two bodies, two legs and two arms.
//!
//! The numbers are those of Gymnasium's humanoid v5 as MuJoCo 3.17.0 compiles it (without its
//! tendons, which exert no force), and of Brax's humanoid. Left and right differ in a few numbers
//! there as well.

mod limbs;

use crate::Field;

use super::{
    Actuator, Algorithm, Geom, Health, Integrator, Noise, Observation, Part, Preset, RobotSpec,
    Shape, Solver, VelocityPoint,
};
use limbs::{LEFT, RIGHT};

const GEARS: [f64; 17] = [
    100.0, 100.0, 100.0, 100.0, 100.0, 300.0, 200.0, 100.0, 100.0, 300.0, 200.0, 25.0, 25.0, 25.0,
    25.0, 25.0, 25.0,
];

/// The humanoid: 42.12 kg, qpos = (position, quaternion, waist z y x, right hip x z y, right knee,
/// left leg, right shoulder 1 2, right elbow, left arm), 17 motors of 10 to 120 N m (gears of 25 to
/// 300, controls in [-0.4, 0.4]), those of the waist in the order y z x.
pub fn humanoid(preset: Preset) -> RobotSpec {
    match preset {
        Preset::GymV5 => gym(),
        Preset::Paper => paper(),
    }
}

fn gym() -> RobotSpec {
    let mut robot = RobotSpec {
        solver: Solver { algorithm: Algorithm::Pgs, iterations: 50, ls_iterations: 50 },
        reset_noise: [Noise::Uniform(0.01); 2],
        health: Health::Height { range: [1.0, 2.0], open: true },
        observation: Observation {
            parts: vec![
                Part::field(Field::Inertia),
                Part::field(Field::Velocity),
                Part::Field { field: Field::ActuatorForce, skip: 6, clip: f64::INFINITY },
                Part::field(Field::ContactForce),
            ],
            ..Observation::free()
        },
        ..build(false)
    };
    robot.geoms.iter_mut().for_each(|geom| geom.margin = 0.001);
    robot.geoms.iter_mut().filter(|geom| geom.body.is_some()).for_each(|geom| geom.condim = 1);
    robot
}

/// Brax welds the feet to the shins, and solves for contacts in a single iteration.
fn paper() -> RobotSpec {
    RobotSpec {
        solver: Solver { algorithm: Algorithm::Newton, iterations: 1, ls_iterations: 4 },
        reset_noise: [Noise::Uniform(0.005); 2],
        health: Health::Height { range: [1.0, 2.0], open: false },
        observation: Observation {
            parts: vec![Part::LinkInertia, Part::LinkVelocity, Part::field(Field::ActuatorForce)],
            ..Observation::free()
        },
        ..build(true).braxed(&["right_foot", "left_foot"])
    }
}

/// What the presets share; the rest is MuJoCo's default.
fn build(fused: bool) -> RobotSpec {
    let motors = [2, 1, 3].into_iter().chain(4..18).zip(GEARS);
    let mut robot = RobotSpec {
        name: "humanoid".into(),
        bodies: Vec::new(),
        joints: Vec::new(),
        geoms: vec![Geom { friction: [1.0, 0.1, 0.1], ..Geom::new("floor", None, Shape::Plane) }],
        actuators: motors
            .map(|(joint, gear)| Actuator { joint, gear, range: [-0.4, 0.4] })
            .collect(),
        gravity: [0.0, 0.0, -9.81],
        timestep: 0.003,
        integrator: Integrator::Rk4,
        solver: Solver::MUJOCO,
        frame_skip: 5,
        initial_qpos: [&[0.0, 0.0, 1.4, 1.0][..], &[0.0; 20]].concat(),
        reset_noise: [Noise::Uniform(0.0); 2],
        health: Health::Always,
        velocity_point: VelocityPoint::Centre,
        observation: Observation::free(),
    };
    let pelvis = robot.trunk();
    robot.leg(pelvis, &RIGHT, fused);
    robot.leg(pelvis, &LEFT, fused);
    robot.arm(&RIGHT);
    robot.arm(&LEFT);
    robot
}
