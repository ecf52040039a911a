//! The hopper: a one-legged robot in the x-z plane, with a torso, a thigh, a leg and a foot.
//!
//! The numbers are those of Gymnasium's hopper v5 as MuJoCo 3.17.0 compiles it, and of Brax's.

use std::f64::consts::{FRAC_PI_4, PI};

use super::planar::{self, Limb};
use super::{
    Actuator, Geom, Health, Integrator, Joint, Noise, Observation, Preset, RobotSpec, Shape,
    Softness, Solver, VelocityPoint,
};

const CONTACT: Softness = Softness { solref: [0.02, 1.0], solimp: [0.8, 0.8, 0.01, 0.5, 2.0] };
/// Height of the torso at the reference pose (m).
const HEIGHT: f64 = 1.25;

#[rustfmt::skip]
const LIMBS: [Limb; 4] = [
    Limb { name: "torso", parent: None,    origin: [0.0, 1.25], ends: [[0.0, 1.45], [0.0, 1.05]],  radius: 0.05, friction: 0.9, joint: [0.0, 1.25] },
    Limb { name: "thigh", parent: Some(0), origin: [0.0, 1.05], ends: [[0.0, 1.05], [0.0, 0.6]],   radius: 0.05, friction: 0.9, joint: [0.0, 1.05] },
    Limb { name: "leg",   parent: Some(1), origin: [0.0, 0.35], ends: [[0.0, 0.6], [0.0, 0.1]],    radius: 0.04, friction: 0.9, joint: [0.0, 0.6] },
    Limb { name: "foot",  parent: Some(2), origin: [0.13, 0.0], ends: [[-0.13, 0.1], [0.26, 0.1]], radius: 0.06, friction: 2.0, joint: [0.0, 0.1] },
];

/// The hopper: 15.82 kg, qpos = (x, z, pitch, thigh, leg, foot), three motors of 200 N m.
pub fn hopper(preset: Preset) -> RobotSpec {
    match preset {
        Preset::GymV5 => gym(),
        Preset::Paper => paper(),
    }
}

fn gym() -> RobotSpec {
    RobotSpec {
        name: "hopper".into(),
        bodies: planar::bodies(&LIMBS),
        joints: joints(HEIGHT, -150.0 * PI / 180.0, FRAC_PI_4),
        geoms: geoms(),
        actuators: (3..6)
            .map(|joint| Actuator { joint, gear: 200.0, range: [-1.0, 1.0] })
            .collect(),
        gravity: [0.0, 0.0, -9.81],
        timestep: 0.002,
        integrator: Integrator::Rk4,
        solver: Solver::MUJOCO,
        frame_skip: 4,
        initial_qpos: vec![0.0, HEIGHT, 0.0, 0.0, 0.0, 0.0],
        reset_noise: [Noise::Uniform(0.005); 2],
        health: Health::Planar {
            height: [0.7, f64::INFINITY],
            pitch: [-0.2, 0.2],
            bound: 100.0,
            lift: 0.0,
        },
        velocity_point: VelocityPoint::X,
        observation: Observation { clip: 10.0, ..Observation::planar() },
    }
}

/// Brax measures z from the reference pose and rounds the joints' limits.
fn paper() -> RobotSpec {
    RobotSpec {
        joints: joints(0.0, -planar::BRAX_150, planar::BRAX_45),
        initial_qpos: vec![0.0; 6],
        health: Health::Planar {
            height: [0.7, f64::INFINITY],
            pitch: [-0.2, 0.2],
            bound: 100.0,
            lift: HEIGHT,
        },
        observation: Observation { clip: 10.0, lift: HEIGHT, ..Observation::planar() },
        ..gym().braxed(&["foot_geom"])
    }
}

fn joints(height: f64, folded: f64, foot: f64) -> Vec<Joint> {
    let mut joints = planar::root(height, Softness::MUJOCO);
    for (index, limb) in LIMBS.iter().enumerate().skip(1) {
        let range = if limb.name == "foot" { [-foot, foot] } else { [folded, 0.0] };
        joints.push(Joint { range: Some(range), damping: 1.0, armature: 1.0, ..limb.hinge(index) });
    }
    joints
}

fn geoms() -> Vec<Geom> {
    let floor = Geom { margin: 0.001, softness: CONTACT, ..Geom::new("floor", None, Shape::Plane) };
    let limbs = LIMBS.iter().enumerate().map(|(index, limb)| {
        let friction = [limb.friction, 0.005, 0.0001];
        Geom {
            friction,
            condim: 1,
            margin: floor.margin,
            softness: floor.softness,
            ..limb.geom(index)
        }
    });
    std::iter::once(floor.clone()).chain(limbs).collect()
}
