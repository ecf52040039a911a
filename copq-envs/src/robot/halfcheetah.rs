//! The half-cheetah: a running robot in the x-z plane, with a torso that carries a head, a back leg
//! and a front leg.
//!
//! The numbers are those of Gymnasium's halfcheetah v5 as MuJoCo 3.17.0 compiles it, and of Brax's.

use super::{
    Actuator, Body, Capsule, Geom, Health, Inertial, Integrator, Joint, Noise, Observation, Preset,
    RobotSpec, Shape, Softness, Solver, VelocityPoint, planar,
};

const RADIUS: f64 = 0.046;
const CONTACT: Softness = Softness { solref: [0.02, 1.0], solimp: [0.0, 0.8, 0.01, 0.5, 2.0] };
const LIMIT: Softness = Softness { solref: [0.02, 1.0], solimp: [0.0, 0.8, 0.03, 0.5, 2.0] };
/// Scales limbs of 1000 kg/m^3 so that the total mass is 14 kg.
const SCALE: f64 = 0.6608849500774736;

/// Torso and head together.
const TORSO: Inertial = Inertial {
    mass: 6.25020920502092,
    com: [0.15238987816307403, 0.0, 0.025398313027179008],
    moments: [0.8971176881117434, 0.8856554522351578, 0.01796092340796636],
    quat: [0.5224297915933479, 0.4765155956059912, 0.4765155956059912, 0.5224297915933479],
};

/// One limb of a leg: a body with one capsule, turned by an angle about y, and the joint at its
/// origin.
struct Limb {
    name: &'static str,
    parent: usize,
    pos: [f64; 2],
    centre: [f64; 2],
    angle: f64,
    half_length: f64,
    range: [f64; 2],
    stiffness: f64,
    damping: f64,
    gear: f64,
}

#[rustfmt::skip]
const LIMBS: [Limb; 6] = [
    Limb { name: "bthigh", parent: 0, pos: [-0.5, 0.0],    centre: [0.1, -0.13],   angle: -3.8,  half_length: 0.145, range: [-0.52, 1.05],   stiffness: 240.0, damping: 6.0, gear: 120.0 },
    Limb { name: "bshin",  parent: 1, pos: [0.16, -0.25],  centre: [-0.14, -0.07], angle: -2.03, half_length: 0.15,  range: [-0.785, 0.785], stiffness: 180.0, damping: 4.5, gear: 90.0 },
    Limb { name: "bfoot",  parent: 2, pos: [-0.28, -0.14], centre: [0.03, -0.097], angle: -0.27, half_length: 0.094, range: [-0.4, 0.785],   stiffness: 120.0, damping: 3.0, gear: 60.0 },
    Limb { name: "fthigh", parent: 0, pos: [0.5, 0.0],     centre: [-0.07, -0.12], angle: 0.52,  half_length: 0.133, range: [-1.0, 0.7],     stiffness: 180.0, damping: 4.5, gear: 120.0 },
    Limb { name: "fshin",  parent: 4, pos: [-0.14, -0.24], centre: [0.065, -0.09], angle: -0.6,  half_length: 0.106, range: [-1.2, 0.87],    stiffness: 120.0, damping: 3.0, gear: 60.0 },
    Limb { name: "ffoot",  parent: 5, pos: [0.13, -0.18],  centre: [0.045, -0.07], angle: -0.6,  half_length: 0.07,  range: [-0.5, 0.5],     stiffness: 60.0,  damping: 1.5, gear: 30.0 },
];

/// The half-cheetah: 14 kg, qpos = (x, z - 0.7 m, pitch, back thigh, shin, foot, front thigh, shin,
/// foot), six motors of 30 to 120 N m. It has no unhealthy state.
pub fn halfcheetah(preset: Preset) -> RobotSpec {
    match preset {
        Preset::GymV5 => gym(),
        Preset::Paper => paper(),
    }
}

fn gym() -> RobotSpec {
    let motors = LIMBS.iter().enumerate();
    RobotSpec {
        name: "halfcheetah".into(),
        bodies: bodies(),
        joints: joints(),
        geoms: geoms(),
        actuators: motors
            .map(|(i, limb)| Actuator { joint: 3 + i, gear: limb.gear, range: [-1.0, 1.0] })
            .collect(),
        gravity: [0.0, 0.0, -9.81],
        timestep: 0.01,
        integrator: Integrator::Euler,
        solver: Solver::MUJOCO,
        frame_skip: 5,
        initial_qpos: vec![0.0; 9],
        reset_noise: [Noise::Uniform(0.1), Noise::Gaussian(0.1)],
        health: Health::Always,
        velocity_point: VelocityPoint::X,
        observation: Observation::planar(),
    }
}

fn paper() -> RobotSpec {
    RobotSpec {
        reset_noise: [Noise::Uniform(0.005), Noise::Gaussian(0.005)],
        ..gym().braxed(&["head", "bthigh", "bfoot", "fthigh", "ffoot"])
    }
}

fn bodies() -> Vec<Body> {
    let limbs = LIMBS.iter().map(|limb| {
        let Inertial { mass, com, moments, quat } = capsule(limb).solid(1000.0);
        let inertial = Inertial {
            mass: SCALE * mass,
            com,
            moments: moments.map(|moment| SCALE * moment),
            quat,
        };
        Body::new(limb.name, Some(limb.parent), at(limb.pos), inertial)
    });
    std::iter::once(Body::new("torso", None, [0.0, 0.0, 0.7], TORSO)).chain(limbs).collect()
}

fn joints() -> Vec<Joint> {
    let mut joints = planar::root(0.0, LIMIT);
    for (index, limb) in LIMBS.iter().enumerate() {
        joints.push(Joint {
            range: Some(limb.range),
            damping: limb.damping,
            armature: 0.1,
            stiffness: limb.stiffness,
            softness: LIMIT,
            ..Joint::hinge(limb.name, index + 1, [0.0, 1.0, 0.0])
        });
    }
    joints
}

fn geoms() -> Vec<Geom> {
    let spine = Capsule::between([-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], RADIUS);
    let head =
        Capsule { radius: RADIUS, half_length: 0.15, centre: [0.6, 0.0, 0.1], quat: pitched(0.87) };
    let mut geoms = vec![
        Geom::new("floor", None, Shape::Plane),
        Geom::capsule("torso", 0, spine),
        Geom::capsule("head", 0, head),
    ];
    geoms.extend(
        LIMBS
            .iter()
            .enumerate()
            .map(|(index, limb)| Geom::capsule(limb.name, index + 1, capsule(limb))),
    );
    for geom in &mut geoms {
        (geom.friction, geom.softness) = ([0.4, 0.1, 0.1], CONTACT);
        geom.conaffinity = geom.body.is_none().into();
    }
    geoms
}

fn capsule(limb: &Limb) -> Capsule {
    let centre = at(limb.centre);
    let quat = pitched(limb.angle);
    Capsule { radius: RADIUS, half_length: limb.half_length, centre, quat }
}

fn at([x, z]: [f64; 2]) -> [f64; 3] {
    [x, 0.0, z]
}

fn pitched(angle: f64) -> [f64; 4] {
    [(angle / 2.0).cos(), 0.0, (angle / 2.0).sin(), 0.0]
}
