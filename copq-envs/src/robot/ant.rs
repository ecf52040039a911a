//! The ant: a ball with four legs of three segments each, two of them movable.
//!
//! The numbers are those of Gymnasium's ant v5 as MuJoCo 3.17.0 compiles it, and of Brax's ant.

use crate::Field;

use super::capsule::{solid_ball, unit};
use super::{
    Actuator, Body, Capsule, Geom, Health, Inertial, Integrator, Joint, Noise, Observation, Part,
    Preset, RobotSpec, Shape, Solver, VelocityPoint,
};

/// Density of everything (kg/m^3).
const DENSITY: f64 = 5.0;
/// Radius of the segments and of Brax's feet (m).
const THIN: f64 = 0.08;
/// The signs of x and y of the legs: front left, front right, back left, back right.
const LEGS: [[f64; 2]; 4] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];

/// The torso with the four segments that are welded to it.
const FUSED: Inertial = Inertial {
    mass: 0.4838802496628035,
    com: [0.0; 3],
    moments: [0.013585715499771953, 0.011120356980366829, 0.011120356980366829],
    quat: [0.5000000000000007, 0.5000000000000007, -0.5000000000000007, 0.5000000000000007],
};

/// The ant: 0.91 kg, qpos = (position, quaternion, then hip and ankle of each leg), eight motors of
/// 150 N m, those of the last leg first.
///
/// Gymnasium's starts with its ankles outside their limits, as in Gymnasium itself; Brax's starts
/// on bent legs.
pub fn ant(preset: Preset) -> RobotSpec {
    match preset {
        Preset::GymV5 => gym(),
        Preset::Paper => paper(),
    }
}

fn gym() -> RobotSpec {
    let mut robot = RobotSpec {
        name: "ant".into(),
        bodies: vec![Body::new(
            "torso",
            None,
            [0.0, 0.0, 0.75],
            solid_ball(DENSITY, 0.25, [0.0; 3]),
        )],
        joints: vec![Joint::free("root", 0)],
        geoms: vec![
            Geom::new("floor", None, Shape::Plane),
            Geom::new("torso_geom", Some(0), Shape::Sphere { radius: 0.25 }),
        ],
        actuators: [7, 8, 1, 2, 3, 4, 5, 6]
            .map(|joint| Actuator { joint, gear: 150.0, range: [-1.0, 1.0] })
            .into(),
        gravity: [0.0, 0.0, -9.81],
        timestep: 0.01,
        integrator: Integrator::Rk4,
        solver: Solver::MUJOCO,
        frame_skip: 5,
        initial_qpos: [&[0.0, 0.0, 0.75, 1.0][..], &[0.0; 11]].concat(),
        reset_noise: [Noise::Uniform(0.1), Noise::Gaussian(0.1)],
        health: Health::Height { range: [0.2, 1.0], open: false },
        velocity_point: VelocityPoint::Body(0),
        observation: Observation {
            optional: vec![Part::Field { field: Field::ContactForce, skip: 0, clip: 1.0 }],
            ..Observation::free()
        },
    };
    for (leg, signs) in LEGS.into_iter().enumerate() {
        let aux = robot.segment(0, &format!("aux_{}", leg + 1), [0.0; 3], along(signs, 0.2));
        robot.movable(leg, signs, aux);
    }
    for geom in &mut robot.geoms {
        (geom.friction, geom.margin) = ([1.0, 0.5, 0.5], 0.01);
        geom.conaffinity = geom.body.is_none().into();
    }
    robot
}

/// Brax welds the first segments to the torso; only four balls at the tips of the legs touch the
/// floor.
fn paper() -> RobotSpec {
    let mut robot = gym();
    robot.bodies = vec![Body { inertial: FUSED, ..robot.bodies.swap_remove(0) }];
    robot.joints.truncate(1);
    robot.geoms.truncate(2);
    for (leg, signs) in LEGS.into_iter().enumerate() {
        let name = format!("aux_{}_geom", leg + 1);
        robot.geoms.push(Geom::capsule(
            &name,
            0,
            Capsule::between([0.0; 3], along(signs, 0.2), THIN),
        ));
    }
    for (leg, signs) in LEGS.into_iter().enumerate() {
        let ankle = robot.movable(leg, signs, 0);
        let foot =
            Geom::new(&format!("foot_{}", leg + 1), Some(ankle), Shape::Sphere { radius: THIN });
        robot.geoms.push(Geom { pos: along(signs, 0.4), ..foot });
    }
    robot.geoms.iter_mut().for_each(|geom| geom.friction = [1.0, 0.5, 0.5]);
    let bent = LEGS.iter().flat_map(|[x, _]| [0.0, *x]);
    RobotSpec {
        initial_qpos: [0.0, 0.0, 0.55, 1.0, 0.0, 0.0, 0.0].into_iter().chain(bent).collect(),
        reset_noise: [Noise::Uniform(0.005), Noise::Gaussian(0.005)],
        velocity_point: VelocityPoint::Xy,
        observation: Observation::free(),
        ..robot.braxed(&["foot_1", "foot_2", "foot_3", "foot_4"])
    }
}

impl RobotSpec {
    /// Adds the hip's segment below `parent` and the ankle's below that; returns the ankle's.
    fn movable(&mut self, leg: usize, signs: [f64; 2], parent: usize) -> usize {
        let number = leg + 1;
        let hip =
            self.segment(parent, &format!("leg_{number}"), along(signs, 0.2), along(signs, 0.2));
        let axis = Joint::hinge(&format!("hip_{number}"), hip, [0.0, 0.0, 1.0]);
        self.joints.push(Joint { range: Some([-30.0, 30.0].map(f64::to_radians)), ..sprung(axis) });
        let ankle =
            self.segment(hip, &format!("ankle_{number}"), along(signs, 0.2), along(signs, 0.4));
        let axis =
            Joint::hinge(&format!("ankle_{number}"), ankle, unit([-signs[0] * signs[1], 1.0, 0.0]));
        let range = if signs[0] > 0.0 { [30.0, 70.0] } else { [-70.0, -30.0] };
        self.joints.push(Joint { range: Some(range.map(f64::to_radians)), ..sprung(axis) });
        ankle
    }

    /// Adds a body that is one capsule from its origin to `end`.
    fn segment(&mut self, parent: usize, name: &str, pos: [f64; 3], end: [f64; 3]) -> usize {
        let body = self.bodies.len();
        let capsule = Capsule::between([0.0; 3], end, THIN);
        self.bodies.push(Body::new(name, Some(parent), pos, capsule.solid(DENSITY)));
        self.geoms.push(Geom::capsule(&format!("{name}_geom"), body, capsule));
        body
    }
}

fn sprung(joint: Joint) -> Joint {
    Joint { damping: 1.0, armature: 1.0, ..joint }
}

/// The point at this distance along both x and y in a leg's direction.
fn along([x, y]: [f64; 2], distance: f64) -> [f64; 3] {
    [x * distance, y * distance, 0.0]
}
