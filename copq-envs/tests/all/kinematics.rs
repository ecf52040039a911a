//! Forward kinematics against MuJoCo 3.17.0.

use crate::support;
use approx::{abs_diff_eq, assert_abs_diff_eq};

use copq_envs::RobotSpec;
use copq_envs::robot::{self, Body, Geom, Inertial, Joint, JointKind, Pose, Preset, Shape};
use support::Table;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// The robot of `data/kinematics.py`: a free trunk with an arm of three joints, and a cart on
/// slides beside it.
fn awkward() -> RobotSpec {
    RobotSpec {
        bodies: vec![
            body(None, [0.1, 0.2, 1.3], [0.8, 0.0, 0.6, 0.0]),
            body(Some(0), [0.3, -0.1, 0.2], [0.5, 0.5, -0.5, 0.5]),
            body(Some(1), [0.0, 0.2, 0.5], [0.8, 0.0, 0.0, -0.6]),
            body(Some(0), [-0.4, 0.0, 0.1], UPRIGHT),
            body(None, [0.0, 0.0, 1.25], UPRIGHT),
        ],
        joints: vec![
            joint(0, JointKind::Free, [0.0; 3], [0.0; 3], 0.0),
            joint(1, JointKind::Slide, [3.0, 0.0, 4.0], [0.0; 3], 0.3),
            joint(1, JointKind::Hinge, [0.0, 4.0, -3.0], [0.1, 0.2, -0.3], -0.4),
            joint(1, JointKind::Hinge, [1.0, 0.0, 0.0], [0.0, -0.1, 0.25], 0.0),
            joint(2, JointKind::Hinge, [0.0, -1.0, 0.0], [0.07, 0.0, -0.02], 0.0),
            joint(4, JointKind::Slide, [1.0, 0.0, 0.0], [0.0, 0.0, -1.25], 0.0),
            joint(4, JointKind::Slide, [0.0, 0.0, 1.0], [0.0, 0.0, -1.25], 1.25),
            joint(4, JointKind::Hinge, [0.0, 1.0, 0.0], [0.0, 0.0, 0.2], 0.0),
        ],
        geoms: vec![
            geom(None, Shape::Sphere { radius: 0.2 }, [1.0, 2.0, 3.0], UPRIGHT),
            geom(
                Some(0),
                Shape::Capsule { radius: 0.1, half_length: 0.3 },
                [0.05, 0.0, -0.02],
                [0.6, 0.8, 0.0, 0.0],
            ),
            geom(
                Some(1),
                Shape::Capsule { radius: 0.04, half_length: 0.2 },
                [0.0, 0.1, 0.2],
                [0.48, 0.64, 0.36, 0.48],
            ),
            geom(Some(2), Shape::Sphere { radius: 0.06 }, [0.02, 0.03, 0.04], UPRIGHT),
            geom(
                Some(3),
                Shape::Capsule { radius: 0.02, half_length: 0.15 },
                [0.0; 3],
                [0.0, 0.6, 0.0, 0.8],
            ),
        ],
        actuators: Vec::new(),
        ..robot::hopper(Preset::GymV5)
    }
}

fn body(parent: Option<usize>, pos: [f64; 3], quat: [f64; 4]) -> Body {
    let inertial = Inertial { mass: 1.0, com: [0.0; 3], moments: [1.0; 3], quat: UPRIGHT };
    Body { name: String::new(), parent, pos, quat, inertial }
}

fn joint(body: usize, kind: JointKind, axis: [f64; 3], anchor: [f64; 3], reference: f64) -> Joint {
    Joint { body, kind, axis, anchor, reference, ..robot::hopper(Preset::GymV5).joints[0].clone() }
}

fn geom(body: Option<usize>, shape: Shape, pos: [f64; 3], quat: [f64; 4]) -> Geom {
    Geom { body, shape, pos, quat, ..robot::hopper(Preset::GymV5).geoms[0].clone() }
}

fn rows(csv: &str) -> impl Iterator<Item = Vec<f64>> {
    csv.lines().map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
}

/// Two poses are one if their quaternions are equal or opposite.
fn check_pose(got: &Pose, wanted: &[f64]) {
    let sign = got.quat.iter().zip(&wanted[3..]).map(|(a, b)| a * b).sum::<f64>().signum();
    let got = [&got.pos[..], &got.quat.map(|x| sign * x)].concat();
    assert_abs_diff_eq!(got[..], *wanted, epsilon = 1e-14);
}

#[test]
fn bodies_and_geoms_are_where_mujoco_puts_them() {
    let robot = awkward();
    for row in rows(include_str!("../data/kinematics.csv")) {
        let (qpos, wanted) = row.split_at(robot.nq());
        let bodies = robot.body_poses(qpos);
        let geoms: Vec<_> = robot.geoms.iter().map(|geom| robot.geom_pose(geom, &bodies)).collect();
        assert_eq!(wanted.len(), 7 * (bodies.len() + geoms.len()));
        bodies
            .iter()
            .chain(&geoms)
            .zip(wanted.chunks(7))
            .for_each(|(got, wanted)| check_pose(got, wanted));
    }
}

#[test]
fn segments_end_on_their_geoms_axes() {
    let robot = awkward();
    let row = rows(include_str!("../data/kinematics.csv")).nth(1).unwrap();
    let bodies = robot.body_poses(&row[..robot.nq()]);
    let segments = robot.segments(&bodies);
    assert_eq!(segments.iter().map(|segment| segment.limb).collect::<Vec<_>>(), [0, 1, 1, 2]);
    for (segment, geom) in segments.iter().zip(&robot.geoms[1..]) {
        let Pose { pos, .. } = robot.geom_pose(geom, &bodies);
        let [a, b] = segment.ends;
        for i in 0..3 {
            assert_abs_diff_eq!(a[i] + b[i], 2.0 * pos[i], epsilon = 1e-14);
        }
        let length = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let Shape::Capsule { half_length, .. } = geom.shape else { continue };
        assert_abs_diff_eq!(length, 2.0 * half_length, epsilon = 1e-14);
    }
    // The floor is no segment, and each part of the upright hopper begins where the one before it
    // ends.
    let hopper = robot::hopper(Preset::GymV5);
    let parts = hopper.segments(&hopper.body_poses(&hopper.initial_qpos));
    let heights: Vec<_> =
        parts.iter().map(|part| part.ends.map(|end| (1e9 * end[2]).round() / 1e9)).collect();
    assert_eq!(heights, [[1.45, 1.05], [1.05, 0.6], [0.6, 0.1], [0.1, 0.1]]);
}

#[test]
fn limbs_begin_where_a_body_has_several_children() {
    for (robot, wanted) in [
        (robot::hopper as fn(Preset) -> RobotSpec, vec![0; 4]),
        (robot::walker2d, vec![0, 1, 1, 1, 2, 2, 2]),
        (robot::halfcheetah, vec![0, 0, 1, 1, 1, 2, 2, 2]),
    ] {
        let robot = robot(Preset::GymV5);
        let segments = robot.segments(&robot.body_poses(&robot.initial_qpos));
        assert_eq!(
            segments.iter().map(|segment| segment.limb).collect::<Vec<_>>(),
            wanted,
            "{}",
            robot.name
        );
    }
}

/// Recorded flights: qpos, and the whole robot's centre of mass as MuJoCo computes it.
#[test]
fn centres_of_mass_are_mujocos() {
    check_flight(robot::hopper, include_str!("../data/flight_gym_hopper.csv"));
    check_flight(robot::walker2d, include_str!("../data/flight_gym_walker2d.csv"));
    check_flight(robot::halfcheetah, include_str!("../data/flight_gym_halfcheetah.csv"));
    check_flight(robot::ant, include_str!("../data/flight_gym_ant.csv"));
    check_flight(robot::humanoid, include_str!("../data/flight_gym_humanoid.csv"));
}

fn check_flight(robot: fn(Preset) -> RobotSpec, flight: &str) {
    let robot = robot(Preset::GymV5);
    let flight = Table::parse(flight);
    assert_eq!(flight.len(), 6);
    for row in 0..flight.len() {
        let centre = robot.centre_of_mass(&robot.body_poses(&flight.vector(row, "qpos")));
        let wanted = ["comx", "comy", "comz"].map(|name| flight.get(row, name).unwrap());
        let close = abs_diff_eq!(centre[..], wanted[..], epsilon = 1e-12);
        assert!(close, "{}: {centre:?} against {wanted:?}", robot.name);
    }
}
