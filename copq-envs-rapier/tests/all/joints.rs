//! Motors, springs, damping and limits of joints against exact solutions.

use crate::support;
use approx::assert_abs_diff_eq;

use copq_envs::robot::Joint;
use copq_envs::{Field, Physics, RobotSpec};
use copq_envs_rapier::Rapier;
use support::parts::{block, contraption, motor};
use support::{qpos, qvel};

/// A block on a hinge through its centre of mass: nothing acts but the joint. The moment of inertia
/// is 0.2 kg m^2.
fn flywheel(joint: Joint) -> RobotSpec {
    contraption(vec![block("wheel", None)], vec![joint])
}

fn hinge() -> Joint {
    Joint::hinge("axle", 0, [0.0, 1.0, 0.0])
}

fn start(spec: &RobotSpec, angle: f64, rate: f64) -> Rapier {
    let mut physics = Rapier::new(spec).unwrap();
    physics.reset_to(&[angle], &[rate]).unwrap();
    physics
}

#[test]
fn motors_act_fully_add_up_and_are_clamped() {
    let mut spec = flywheel(Joint { armature: 0.3, ..hinge() });
    spec.actuators = vec![motor(0, 30.0), motor(0, -10.0)];
    let mut physics = start(&spec, 0.0, 0.0);
    // 0.5 x 30 - 1 x 10 = 5 N m on 0.5 kg m^2; the second control is clamped to 1.
    physics.step(&[0.5, 2.0], 10).unwrap();
    assert_abs_diff_eq!(qvel(&physics)[0] / (10.0 * 0.002 * 10.0), 1.0, epsilon = 1e-6);
    let mut force = [0.0];
    physics.read(Field::ActuatorForce, &mut force).unwrap();
    assert_eq!(force, [5.0]);
}

#[test]
fn motors_may_come_in_another_order_than_joints() {
    let bodies = vec![block("wheel", None), block("other", None)];
    let mut spec = contraption(bodies, vec![hinge(), Joint::hinge("other", 1, hinge().axis)]);
    spec.actuators = vec![motor(1, 2.0), motor(0, 1.0)];
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&[0.0; 2], &[0.0; 2]).unwrap();
    physics.step(&[1.0, 0.5], 1).unwrap();
    let momenta: Vec<f64> = qvel(&physics).iter().map(|velocity| velocity * 0.2).collect();
    assert_abs_diff_eq!(momenta[..], [0.001, 0.004][..], epsilon = 1e-9);
}

/// rapier damps every angular freedom by 0.1 N m s/rad unless told otherwise: the wheel would stop
/// within seconds.
#[test]
fn without_damping_it_turns_for_ever() {
    let mut wheel = start(&flywheel(hinge()), 0.0, 3.0);
    wheel.step(&[], 5000).unwrap();
    assert_abs_diff_eq!(qvel(&wheel)[0], 3.0, epsilon = 1e-9);
    let spec = RobotSpec {
        gravity: [0.0; 3],
        ..contraption(vec![block("top", None)], vec![Joint::free("free", 0)])
    };
    let mut top = Rapier::new(&spec).unwrap();
    top.reset_to(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], &[0.0, 0.0, 0.0, 0.0, 0.0, 3.0]).unwrap();
    top.step(&[], 5000).unwrap();
    assert_abs_diff_eq!(qvel(&top)[5], 3.0, epsilon = 1e-9);
}

/// Damping at the end of the timestep, springs at its start: MuJoCo's Euler.
#[test]
fn damping_is_implicit_and_springs_are_not() {
    let damped = start(&flywheel(Joint { damping: 0.5, ..hinge() }), 0.0, 3.0);
    let sprung = start(&flywheel(Joint { stiffness: 50.0, reference: 0.1, ..hinge() }), 0.3, 0.0);
    let rates = [damped, sprung].map(|mut physics| {
        physics.step(&[], 1).unwrap();
        qvel(&physics)[0]
    });
    assert_abs_diff_eq!(rates[0], 3.0 / (1.0 + 0.002 * 0.5 / 0.2), epsilon = 1e-9);
    assert_abs_diff_eq!(rates[1], -0.002 * 50.0 * 0.2 / 0.2, epsilon = 1e-6);
}

/// MuJoCo's default limit is critically damped with a time constant tc of 0.02 s, and pushes only:
/// the violation shrinks as x0 (1 + t) exp(-t) while t < 1, in units of tc, and after that, when
/// the limit would have to pull, at constant speed.
#[test]
fn a_violated_limit_gives_way_as_told() {
    for (range, sign) in [([0.0, 9.0], 1.0), ([-9.0, 0.0], -1.0)] {
        let mut wheel = start(&flywheel(Joint { range: Some(range), ..hinge() }), -0.3 * sign, 0.0);
        for step in 1..=40 {
            wheel.step(&[], 1).unwrap();
            let t = f64::from(step) * 0.002 / 0.02;
            let exact =
                0.3 * if t < 1.0 { (1.0 + t) * (-t).exp() } else { (3.0 - t) * (-1.0_f64).exp() };
            assert_abs_diff_eq!(qpos(&wheel)[0] * -sign, exact, epsilon = 0.01);
        }
    }
}

/// What hits a limit goes through it for a few hundredths of a second: x = v0 t exp(-t / tc), as in
/// MuJoCo.
#[test]
fn what_hits_a_limit_is_caught_softly() {
    let mut wheel = start(&flywheel(Joint { range: Some([0.0, 9.0]), ..hinge() }), -1e-9, -5.0);
    let deepest = (0..40).fold(0.0_f64, |deepest, _| {
        wheel.step(&[], 1).unwrap();
        deepest.min(qpos(&wheel)[0])
    });
    let exact = -5.0 * 0.02 * (-1.0_f64).exp();
    assert_abs_diff_eq!(deepest / exact, 1.0, epsilon = 0.12);
}

/// A limit takes the share d of what pushes into it: a0 (1 - d) = d k d r at rest.
#[test]
fn a_limit_bears_a_motor() {
    let mut spec = flywheel(Joint { range: Some([0.0, 9.0]), ..hinge() });
    spec.actuators = vec![motor(0, 40.0)];
    let mut wheel = start(&spec, 0.0, 0.0);
    wheel.step(&[-1.0], 500).unwrap();
    let d = 0.95;
    let tc = 0.02;
    let depth = (1.0 - d) * (40.0 / 0.2) / (d * d / (d * tc * d * tc));
    assert_abs_diff_eq!(qvel(&wheel)[0], 0.0, epsilon = 1e-6);
    assert_abs_diff_eq!(qpos(&wheel)[0] / -depth, 1.0, epsilon = 0.15);
    // It lets go as if it had never been there.
    let before = qpos(&wheel)[0];
    wheel.step(&[1.0], 1).unwrap();
    wheel.step(&[1.0], 20).unwrap();
    let t = 21.0 * 0.002;
    assert!((qpos(&wheel)[0] - before) / (0.5 * 200.0 * t * t) > 0.9, "{:?}", qpos(&wheel));
}
