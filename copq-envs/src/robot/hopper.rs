//! The hopper: a one-legged robot in the x-z plane, with a torso, a thigh, a leg and a foot.
//!
//! Facts of Gymnasium's hopper v5 as MuJoCo 3.17.0 compiles them; masses and inertias follow from the capsules.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};

use super::{Actuator, Body, Geom, Inertial, Integrator, Joint, JointKind, Noise, RobotSpec, Shape, Softness, Solver};

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
/// Turns a capsule's axis from z to -x.
const LYING: [f64; 4] = [FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2, 0.0];
const CONTACT: Softness = Softness { solref: [0.02, 1.0], solimp: [0.8, 0.8, 0.01, 0.5, 2.0] };
const MARGIN: f64 = 0.001;
const SPIN_AND_ROLL: [f64; 2] = [0.005, 0.0001];
/// Density of every limb (kg/m^3).
const DENSITY: f64 = 1000.0;

/// One limb: a body with one capsule.
struct Limb {
    name: &'static str,
    pos: [f64; 3],
    radius: f64,
    half_length: f64,
    centre: [f64; 3],
    quat: [f64; 4],
    friction: f64,
}

#[rustfmt::skip]
const LIMBS: [Limb; 4] = [
    Limb { name: "torso", pos: [0.0, 0.0, 1.25],   radius: 0.05, half_length: 0.2,   centre: [0.0, 0.0, 0.0],    quat: UPRIGHT, friction: 0.9 },
    Limb { name: "thigh", pos: [0.0, 0.0, -0.2],   radius: 0.05, half_length: 0.225, centre: [0.0, 0.0, -0.225], quat: UPRIGHT, friction: 0.9 },
    Limb { name: "leg",   pos: [0.0, 0.0, -0.7],   radius: 0.04, half_length: 0.25,  centre: [0.0, 0.0, 0.0],    quat: UPRIGHT, friction: 0.9 },
    Limb { name: "foot",  pos: [0.13, 0.0, -0.35], radius: 0.06, half_length: 0.195, centre: [-0.065, 0.0, 0.1], quat: LYING,   friction: 2.0 },
];

/// The hopper of Gymnasium v5: 15.82 kg, qpos = (x, z, pitch, thigh, leg, foot), three motors of 200 N m.
pub fn hopper() -> RobotSpec {
    RobotSpec {
        name: "hopper".into(),
        bodies: LIMBS.iter().enumerate().map(|(index, limb)| body(index, limb)).collect(),
        joints: joints(),
        geoms: geoms(),
        actuators: (3..6).map(|joint| Actuator { joint, gear: 200.0, range: [-1.0, 1.0] }).collect(),
        gravity: [0.0, 0.0, -9.81],
        timestep: 0.002,
        integrator: Integrator::Rk4,
        solver: Solver::MUJOCO,
        frame_skip: 4,
        initial_qpos: vec![0.0, 1.25, 0.0, 0.0, 0.0, 0.0],
        reset_noise: [Noise::Uniform(0.005); 2],
    }
}

fn body(index: usize, limb: &Limb) -> Body {
    let inertial = Inertial::capsule(DENSITY, limb.radius, limb.half_length, limb.centre, limb.quat);
    Body { name: limb.name.into(), parent: index.checked_sub(1), pos: limb.pos, quat: UPRIGHT, inertial }
}

fn joints() -> Vec<Joint> {
    let folding = [-150.0 * PI / 180.0, 0.0];
    vec![
        root("rootx", JointKind::Slide, [1.0, 0.0, 0.0], [0.0, 0.0, -1.25], 0.0),
        root("rootz", JointKind::Slide, [0.0, 0.0, 1.0], [0.0, 0.0, -1.25], 1.25),
        root("rooty", JointKind::Hinge, [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], 0.0),
        hinge("thigh_joint", 1, [0.0, 0.0, 0.0], folding),
        hinge("leg_joint", 2, [0.0, 0.0, 0.25], folding),
        hinge("foot_joint", 3, [-0.13, 0.0, 0.1], [-FRAC_PI_4, FRAC_PI_4]),
    ]
}

fn root(name: &str, kind: JointKind, axis: [f64; 3], anchor: [f64; 3], reference: f64) -> Joint {
    Joint {
        name: name.into(),
        body: 0,
        kind,
        axis,
        anchor,
        reference,
        range: None,
        damping: 0.0,
        armature: 0.0,
        stiffness: 0.0,
        softness: Softness::MUJOCO,
    }
}

fn hinge(name: &str, body: usize, anchor: [f64; 3], range: [f64; 2]) -> Joint {
    let axis = [0.0, -1.0, 0.0];
    let joint = root(name, JointKind::Hinge, axis, anchor, 0.0);
    Joint { body, range: Some(range), damping: 1.0, armature: 1.0, ..joint }
}

fn geoms() -> Vec<Geom> {
    let floor = Geom {
        name: "floor".into(),
        body: None,
        shape: Shape::Plane,
        pos: [0.0; 3],
        quat: UPRIGHT,
        friction: with_slide(1.0),
        condim: 3,
        contype: 1,
        conaffinity: 1,
        margin: MARGIN,
        softness: CONTACT,
    };
    let limbs = LIMBS.iter().enumerate().map(|(index, limb)| Geom {
        name: format!("{}_geom", limb.name),
        body: Some(index),
        shape: Shape::Capsule { radius: limb.radius, half_length: limb.half_length },
        pos: limb.centre,
        quat: limb.quat,
        friction: with_slide(limb.friction),
        condim: 1,
        ..floor.clone()
    });
    std::iter::once(floor.clone()).chain(limbs).collect()
}

fn with_slide(slide: f64) -> [f64; 3] {
    [slide, SPIN_AND_ROLL[0], SPIN_AND_ROLL[1]]
}
