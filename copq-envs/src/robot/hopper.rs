//! The hopper: a one-legged robot in the x-z plane, with a torso, a thigh, a leg and a foot.
//!
//! Facts of Gymnasium's hopper v5 as MuJoCo 3.17.0 compiles them, and of Brax's.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};

use super::{
    Actuator, Body, Geom, Health, Inertial, Integrator, Joint, Noise, Observation, Preset, RobotSpec, Shape, Softness,
    Solver, Track, planar,
};

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
/// Turns a capsule's axis from z to -x.
const LYING: [f64; 4] = [FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2, 0.0];
const CONTACT: Softness = Softness { solref: [0.02, 1.0], solimp: [0.8, 0.8, 0.01, 0.5, 2.0] };
/// Height of the torso at the reference pose (m).
const HEIGHT: f64 = 1.25;

/// One limb: a body with one capsule of 1000 kg/m^3.
struct Limb {
    name: &'static str,
    pos: [f64; 3],
    radius: f64,
    half_length: f64,
    centre: [f64; 3],
    quat: [f64; 4],
    friction: f64,
    /// Mass (kg), then moments of inertia across and along the capsule (kg m^2): `Capsule::solid` but for last digits,
    /// kept so that published runs repeat bit for bit.
    inertia: [f64; 3],
}

#[rustfmt::skip]
const LIMBS: [Limb; 4] = [
    Limb { name: "torso", pos: [0.0, 0.0, 1.25],   radius: 0.05, half_length: 0.2,   centre: [0.0, 0.0, 0.0],    quat: UPRIGHT, friction: 0.9,
           inertia: [3.6651914291880923, 0.06924593807287505, 0.004450589592585542] },
    Limb { name: "thigh", pos: [0.0, 0.0, -0.2],   radius: 0.05, half_length: 0.225, centre: [0.0, 0.0, -0.225], quat: UPRIGHT, friction: 0.9,
           inertia: [4.057890510886817, 0.0932987568269219, 0.004941463444708947] },
    Limb { name: "leg",   pos: [0.0, 0.0, -0.7],   radius: 0.04, half_length: 0.25,  centre: [0.0, 0.0, 0.0],    quat: UPRIGHT, friction: 0.9,
           inertia: [2.7813566959781637, 0.07230254017320971, 0.0021821921450855186] },
    Limb { name: "foot",  pos: [0.13, 0.0, -0.35], radius: 0.06, half_length: 0.195, centre: [-0.065, 0.0, 0.1], quat: LYING,   friction: 2.0,
           inertia: [5.315574769873929, 0.10352308059000534, 0.009242314259448882] },
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
        bodies: LIMBS.iter().enumerate().map(|(index, limb)| body(index, limb)).collect(),
        joints: joints(HEIGHT, -150.0 * PI / 180.0, FRAC_PI_4),
        geoms: geoms(),
        actuators: (3..6).map(|joint| Actuator { joint, gear: 200.0, range: [-1.0, 1.0] }).collect(),
        gravity: [0.0, 0.0, -9.81],
        timestep: 0.002,
        integrator: Integrator::Rk4,
        solver: Solver::MUJOCO,
        frame_skip: 4,
        initial_qpos: vec![0.0, HEIGHT, 0.0, 0.0, 0.0, 0.0],
        reset_noise: [Noise::Uniform(0.005); 2],
        health: Health::Planar { height: [0.7, f64::INFINITY], pitch: [-0.2, 0.2], bound: 100.0, lift: 0.0 },
        track: Track::X,
        observation: Observation { clip: 10.0, ..Observation::planar() },
    }
}

/// Brax counts z from the reference pose and rounds the joints' limits.
fn paper() -> RobotSpec {
    RobotSpec {
        joints: joints(0.0, -planar::BRAX_150, planar::BRAX_45),
        initial_qpos: vec![0.0; 6],
        health: Health::Planar { height: [0.7, f64::INFINITY], pitch: [-0.2, 0.2], bound: 100.0, lift: HEIGHT },
        observation: Observation { clip: 10.0, lift: HEIGHT, ..Observation::planar() },
        ..gym().braxed(&["foot_geom"])
    }
}

fn body(index: usize, limb: &Limb) -> Body {
    let [mass, across, along] = limb.inertia;
    let inertial = Inertial { mass, com: limb.centre, moments: [across, across, along], quat: limb.quat };
    Body::new(limb.name, index.checked_sub(1), limb.pos, inertial)
}

fn joints(height: f64, folded: f64, foot: f64) -> Vec<Joint> {
    let mut joints = planar::root(height, Softness::MUJOCO);
    joints.extend([
        hinge("thigh_joint", 1, [0.0, 0.0, 0.0], [folded, 0.0]),
        hinge("leg_joint", 2, [0.0, 0.0, 0.25], [folded, 0.0]),
        hinge("foot_joint", 3, [-0.13, 0.0, 0.1], [-foot, foot]),
    ]);
    joints
}

fn hinge(name: &str, body: usize, anchor: [f64; 3], range: [f64; 2]) -> Joint {
    let joint = Joint::hinge(name, body, [0.0, -1.0, 0.0]);
    Joint { anchor, range: Some(range), damping: 1.0, armature: 1.0, ..joint }
}

fn geoms() -> Vec<Geom> {
    let floor = Geom { margin: 0.001, softness: CONTACT, ..Geom::new("floor", None, Shape::Plane) };
    let limbs = LIMBS.iter().enumerate().map(|(index, limb)| Geom {
        name: format!("{}_geom", limb.name),
        body: Some(index),
        shape: Shape::Capsule { radius: limb.radius, half_length: limb.half_length },
        pos: limb.centre,
        quat: limb.quat,
        friction: [limb.friction, 0.005, 0.0001],
        condim: 1,
        ..floor.clone()
    });
    std::iter::once(floor.clone()).chain(limbs).collect()
}
