//! The walker: a two-legged robot in the x-z plane, with a torso, two thighs, two legs and two
//! feet.
//!
//! The numbers are those of Gymnasium's walker2d v5 as MuJoCo 3.17.0 compiles it, and of Brax's.

use std::f64::consts::{FRAC_PI_4, PI};

use super::planar::{self, Limb};
use super::{
    Actuator, Geom, Health, Integrator, Joint, Noise, Observation, Preset, RobotSpec, Shape,
    Softness, Solver, VelocityPoint,
};

/// Height of the torso at the reference pose (m).
const HEIGHT: f64 = 1.25;
#[rustfmt::skip]
const LIMBS: [Limb; 7] = [
    Limb { name: "torso",      parent: None,    origin: [0.0, 1.25], ends: [[0.0, 1.45], [0.0, 1.05]], radius: 0.05, friction: 0.9, joint: [0.0, 1.25] },
    Limb { name: "thigh",      parent: Some(0), origin: [0.0, 1.05], ends: [[0.0, 1.05], [0.0, 0.6]],  radius: 0.05, friction: 0.9, joint: [0.0, 1.05] },
    Limb { name: "leg",        parent: Some(1), origin: [0.0, 0.35], ends: [[0.0, 0.6], [0.0, 0.1]],   radius: 0.04, friction: 0.9, joint: [0.0, 0.6] },
    Limb { name: "foot",       parent: Some(2), origin: [0.2, 0.0],  ends: [[0.0, 0.1], [0.2, 0.1]],   radius: 0.06, friction: 1.9, joint: [0.0, 0.1] },
    Limb { name: "thigh_left", parent: Some(0), origin: [0.0, 1.05], ends: [[0.0, 1.05], [0.0, 0.6]],  radius: 0.05, friction: 0.9, joint: [0.0, 1.05] },
    Limb { name: "leg_left",   parent: Some(4), origin: [0.0, 0.35], ends: [[0.0, 0.6], [0.0, 0.1]],   radius: 0.04, friction: 0.9, joint: [0.0, 0.6] },
    Limb { name: "foot_left",  parent: Some(5), origin: [0.2, 0.0],  ends: [[0.0, 0.1], [0.2, 0.1]],   radius: 0.06, friction: 1.9, joint: [0.0, 0.1] },
];

/// The walker: 23.68 kg, qpos = (x, z, pitch, right thigh, leg, foot, left thigh, leg, foot), six
/// motors of 100 N m.
pub fn walker2d(preset: Preset) -> RobotSpec {
    match preset {
        Preset::GymV5 => gym(),
        Preset::Paper => paper(),
    }
}

fn gym() -> RobotSpec {
    RobotSpec {
        name: "walker2d".into(),
        bodies: planar::bodies(&LIMBS),
        joints: joints(HEIGHT, -150.0 * PI / 180.0, FRAC_PI_4),
        geoms: geoms(),
        actuators: (3..9)
            .map(|joint| Actuator { joint, gear: 100.0, range: [-1.0, 1.0] })
            .collect(),
        gravity: [0.0, 0.0, -9.81],
        timestep: 0.002,
        integrator: Integrator::Rk4,
        solver: Solver::MUJOCO,
        frame_skip: 4,
        initial_qpos: [&[0.0, HEIGHT][..], &[0.0; 7]].concat(),
        reset_noise: [Noise::Uniform(0.005); 2],
        health: Health::Planar {
            height: [0.8, 2.0],
            pitch: [-1.0, 1.0],
            bound: f64::INFINITY,
            lift: 0.0,
        },
        velocity_point: VelocityPoint::X,
        observation: Observation { clip: 10.0, ..Observation::planar() },
    }
}

/// Brax measures z from the reference pose, rounds the joints' limits, and has a smoother right
/// foot.
fn paper() -> RobotSpec {
    let mut robot = gym().braxed(&["torso_geom", "foot_geom", "foot_left_geom"]);
    robot
        .geoms
        .iter_mut()
        .filter(|geom| geom.name == "foot_geom")
        .for_each(|foot| foot.friction[0] = 0.9);
    RobotSpec {
        joints: joints(0.0, -planar::BRAX_150, planar::BRAX_45),
        initial_qpos: vec![0.0; 9],
        health: Health::Planar {
            height: [0.8, 2.0],
            pitch: [-1.0, 1.0],
            bound: f64::INFINITY,
            lift: HEIGHT,
        },
        observation: Observation { clip: 10.0, lift: HEIGHT, ..Observation::planar() },
        ..robot
    }
}

fn joints(height: f64, folded: f64, foot: f64) -> Vec<Joint> {
    let mut joints = planar::root(height, Softness::MUJOCO);
    for (index, limb) in LIMBS.iter().enumerate().skip(1) {
        let range = if limb.name.starts_with("foot") { [-foot, foot] } else { [folded, 0.0] };
        joints.push(Joint {
            range: Some(range),
            damping: 0.1,
            armature: 0.01,
            ..limb.hinge(index)
        });
    }
    joints
}

fn geoms() -> Vec<Geom> {
    let floor = Geom { friction: [0.7, 0.1, 0.1], ..Geom::new("floor", None, Shape::Plane) };
    let limbs = LIMBS.iter().enumerate();
    let limbs = limbs.map(|(index, limb)| Geom {
        friction: [limb.friction, 0.1, 0.1],
        conaffinity: 0,
        ..limb.geom(index)
    });
    std::iter::once(floor).chain(limbs).collect()
}
