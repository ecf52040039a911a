//! What may touch what, and when: masks, parents, the world, margins, sleep.

use crate::support;

use approx::assert_abs_diff_eq;
use copq_envs::robot::{Body, Geom, Joint, Preset};
use copq_envs::{Field, Physics, RobotSpec};
use copq_envs_rapier::Rapier;
use support::parts::{ball, block, contraption, floor, motor};
use support::{qpos, robot};

/// Whether anything presses on anything after one timestep at this pose.
fn touches(spec: &RobotSpec, qpos: &[f64]) -> bool {
    let mut physics = Rapier::new(spec).unwrap();
    physics.reset_to(qpos, &vec![0.0; spec.nv()]).unwrap();
    physics.step(&vec![0.0; spec.nu()], 1).unwrap();
    let mut forces = vec![0.0; 6 * spec.bodies.len()];
    physics.read(Field::ContactForce, &mut forces).unwrap();
    forces.iter().any(|force| *force != 0.0)
}

/// Three balls of 0.2 m one within the other, each body moved by two hinges, so that massless links
/// lie between them.
fn nested(middle: Vec<Joint>) -> RobotSpec {
    let bodies = vec![block("first", None), block("second", Some(0)), block("third", Some(1))];
    let hinges = |body| [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|axis| Joint::hinge("", body, axis));
    let joints = hinges(0).into_iter().chain(middle).chain(hinges(2)).collect();
    let mut spec = contraption(bodies, joints);
    // Off the hinges, so that a contact can turn them.
    let balls =
        (0..3).map(|body| Geom { pos: [0.0, 0.05 * body as f64, 0.15], ..ball(Some(body), 0.2) });
    spec.geoms = balls.collect();
    spec
}

#[test]
fn parents_and_children_do_not_touch_across_massless_links() {
    let joints = vec![Joint::hinge("z", 1, [0.0, 0.0, 1.0]), Joint::hinge("y", 1, [0.0, 1.0, 0.0])];
    let mut spec = nested(joints);
    assert!(touches(&spec, &[0.0; 6]), "first and third may");
    spec.geoms.remove(2);
    assert!(!touches(&spec, &[0.0; 6]));
}

/// The second body has no joint, so it is one with the first, whose child the third becomes.
#[test]
fn welded_bodies_count_as_one() {
    assert!(!touches(&nested(Vec::new()), &[0.0; 4]));
}

#[test]
fn masks_decide() {
    let mut spec = nested(vec![Joint::hinge("z", 1, [0.0, 0.0, 1.0])]);
    for (contype, conaffinity, wanted) in [(1, 2, false), (3, 2, true), (2, 0, false)] {
        spec.geoms
            .iter_mut()
            .for_each(|geom| (geom.contype, geom.conaffinity) = (contype, conaffinity));
        assert_eq!(touches(&spec, &[0.0; 5]), wanted, "{contype} {conaffinity}");
    }
}

#[test]
fn the_humanoid_does_not_press_against_itself_in_its_first_pose() {
    let mut spec = robot("humanoid", Preset::GymV5);
    spec.geoms.retain(|geom| geom.body.is_some());
    assert!(!touches(&spec, &spec.initial_qpos));
    // Arms through the torso are another matter.
    let mut folded = spec.initial_qpos.clone();
    (folded[18], folded[21]) = (1.0, -1.0);
    (folded[20], folded[23]) = (-1.5, -1.5);
    assert!(touches(&spec, &folded));
}

/// Two balls on roots of their own, one on the floor of the world, one on a table that stands there
/// without a joint.
#[test]
fn several_roots_and_the_world_carry_geoms() {
    let table = Body { pos: [5.0, 0.0, 1.0], ..block("table", None) };
    let bodies = vec![block("low", None), block("high", None), table];
    let mut spec = contraption(bodies, vec![Joint::free("low", 0), Joint::free("high", 1)]);
    spec.geoms = vec![
        ball(Some(0), 0.1),
        ball(Some(1), 0.1),
        floor(0.0),
        Geom { body: Some(2), ..ball(None, 0.5) },
    ];
    let mut physics = Rapier::new(&spec).unwrap();
    let upright = [1.0, 0.0, 0.0, 0.0];
    let start = [&[0.0, 0.0, 0.3], &upright[..], &[5.0, 0.0, 1.8], &upright[..]].concat();
    physics.reset_to(&start, &[0.0; 12]).unwrap();
    physics.step(&[], 1000).unwrap();
    let pose = qpos(&physics);
    assert_abs_diff_eq!(pose[2], 0.1, epsilon = 1e-3);
    assert_abs_diff_eq!(pose[9], 1.6, epsilon = 1e-3);
}

/// A margin on both sides adds up, and contacts begin there.
#[test]
fn margins_hold_a_distance() {
    let mut spec =
        contraption(vec![block("ball", None)], vec![Joint::slide("z", 0, [0.0, 0.0, 1.0])]);
    spec.geoms =
        vec![Geom { margin: 0.01, ..ball(Some(0), 0.1) }, Geom { margin: 0.02, ..floor(0.0) }];
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&[0.2], &[0.0]).unwrap();
    physics.step(&[], 1000).unwrap();
    assert_abs_diff_eq!(qpos(&physics)[0], 0.13, epsilon = 1e-3);
}

/// Nothing is held back on the way to the floor, however fast: continuous collision detection
/// would.
#[test]
fn what_falls_fast_falls_freely() {
    let mut spec =
        contraption(vec![block("ball", None)], vec![Joint::slide("z", 0, [0.0, 0.0, 1.0])]);
    spec.geoms = vec![ball(Some(0), 0.1), floor(0.0)];
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&[0.1001], &[-40.0]).unwrap();
    physics.step(&[], 1).unwrap();
    let wanted = 0.1001 - 0.002 * (40.0 + 0.002 * 9.81);
    assert_abs_diff_eq!(qpos(&physics)[0], wanted, epsilon = 1e-12);
}

/// After ten seconds at rest a motor moves it at once.
#[test]
fn nothing_sleeps() {
    let mut spec =
        contraption(vec![block("ball", None)], vec![Joint::slide("z", 0, [0.0, 0.0, 1.0])]);
    spec.geoms = vec![ball(Some(0), 0.1), floor(0.0)];
    spec.actuators = vec![motor(0, 100.0)];
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&[0.1], &[0.0]).unwrap();
    physics.step(&[0.0], 5000).unwrap();
    let rest = qpos(&physics)[0];
    physics.step(&[1.0], 50).unwrap();
    let height = qpos(&physics)[0] - rest;
    assert_abs_diff_eq!(height / (0.5 * (50.0 - 9.81) * 0.01), 1.0, epsilon = 0.05);
}
