//! Masses and the joint-space mass matrix, against MuJoCo's compiled model and against sums over the bodies.

use copq_envs::robot::{self, JointKind, Preset};
use copq_envs::{Physics, RobotSpec};
use copq_envs_rapier::Rapier;
use serde_json::Value;

const POSES: [[f64; 6]; 3] =
    [[0.0, 1.25, 0.0, 0.0, 0.0, 0.0], [0.3, 1.1, -0.15, -0.4, -1.1, 0.6], [-2.0, 1.4, 0.9, -2.4, -0.2, -0.7]];

fn model() -> Value {
    serde_json::from_str(include_str!("data/model_gym_hopper.json")).unwrap()
}

fn mass_matrix(qpos: &[f64; 6]) -> Vec<f64> {
    let mut physics = Rapier::new(&robot::hopper(Preset::GymV5)).unwrap();
    physics.reset_to(qpos, &[0.0; 6]).unwrap();
    physics.mass_matrix().unwrap()
}

#[test]
fn the_diagonal_is_mujocos() {
    let matrix = mass_matrix(&POSES[0]);
    for (dof, entry) in model()["dofs"].as_array().unwrap().iter().enumerate() {
        let wanted = entry["M0"].as_f64().unwrap();
        assert!((matrix[dof * 7] - wanted).abs() < 1e-9, "{dof}: {} against {wanted}", matrix[dof * 7]);
    }
}

#[test]
fn the_whole_matrix_is_the_sum_over_bodies() {
    let spec = robot::hopper(Preset::GymV5);
    let mut worst = 0.0_f64;
    for pose in &POSES {
        for (got, wanted) in mass_matrix(pose).iter().zip(composite(&spec, pose)) {
            assert!(got.is_finite());
            worst = worst.max((got - wanted).abs());
        }
    }
    println!("worst error of the mass matrix: {worst:e}");
    assert!(worst < 1e-9, "{worst:e}");
}

type V = [f64; 3];

/// M = sum over bodies of m Jv'Jv + Jw' I Jw, plus armature; for robots whose frames only slide and pitch about y.
fn composite(spec: &RobotSpec, qpos: &[f64]) -> Vec<f64> {
    let n = spec.nv();
    let mut matrix = vec![0.0; n * n];
    let frames = frames(spec, qpos);
    for (index, body) in spec.bodies.iter().enumerate() {
        let centre = place(&frames[index], body.inertial.com);
        let columns: Vec<_> = (0..n).map(|joint| column(spec, &frames, joint, index, centre)).collect();
        // Every principal frame is the body's turned about y, so the moment about y is the second one.
        let moment = body.inertial.moments[1];
        for (i, (vi, wi)) in columns.iter().enumerate() {
            for (j, (vj, wj)) in columns.iter().enumerate() {
                matrix[i * n + j] += body.inertial.mass * dot(*vi, *vj) + moment * wi * wj;
            }
        }
    }
    (0..n).for_each(|i| matrix[i * n + i] += spec.joints[i].armature);
    matrix
}

/// A frame in the plane: origin, and pitch about y.
struct Frame {
    origin: V,
    pitch: f64,
}

fn frames(spec: &RobotSpec, qpos: &[f64]) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::new();
    for (index, body) in spec.bodies.iter().enumerate() {
        let ground = Frame { origin: [0.0; 3], pitch: 0.0 };
        let parent = body.parent.map_or(&ground, |parent| &frames[parent]);
        let mut frame = Frame { origin: place(parent, body.pos), pitch: parent.pitch };
        for (joint, spec) in spec.joints_of(index) {
            let q = qpos[joint] - spec.reference;
            match spec.kind {
                JointKind::Slide => frame.origin = add(frame.origin, turn(parent.pitch, spec.axis), q),
                _ => {
                    let anchor = place(&frame, spec.anchor);
                    frame.pitch += q * spec.axis[1];
                    frame.origin = add(anchor, turn(frame.pitch, spec.anchor), -1.0);
                }
            }
        }
        frames.push(frame);
    }
    frames
}

/// The velocity of a point of a body, and the body's pitch rate, for unit speed of a joint.
fn column(spec: &RobotSpec, frames: &[Frame], joint: usize, body: usize, point: V) -> (V, f64) {
    let joint = &spec.joints[joint];
    let mut ancestor = Some(body);
    while ancestor.is_some_and(|index| index != joint.body) {
        ancestor = ancestor.and_then(|index| spec.bodies[index].parent);
    }
    match (ancestor, joint.kind) {
        (None, _) => ([0.0; 3], 0.0),
        (Some(_), JointKind::Slide) => (joint.axis, 0.0),
        (Some(_), _) => {
            let arm = add(point, place(&frames[joint.body], joint.anchor), -1.0);
            let rate = joint.axis[1];
            ([rate * arm[2], 0.0, -rate * arm[0]], rate)
        }
    }
}

fn place(frame: &Frame, local: V) -> V {
    add(frame.origin, turn(frame.pitch, local), 1.0)
}

fn turn(pitch: f64, [x, y, z]: V) -> V {
    let (sin, cos) = pitch.sin_cos();
    [cos * x + sin * z, y, cos * z - sin * x]
}

fn add(a: V, b: V, factor: f64) -> V {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
