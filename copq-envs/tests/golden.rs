//! The hopper and its task against numbers from MuJoCo 3.17.0 and Gymnasium v5.

mod support;

use copq::{Env, Outcome};
use copq_envs::{Locomotion, robot, task};
use serde_json::Value;
use support::Recording;

/// A recorded run: the names of the columns, and the rows.
struct Run {
    names: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
}

impl Run {
    fn read() -> Self {
        let mut lines = include_str!("data/hopper_rollout_50.csv").lines();
        let names = lines.next().unwrap().split(',').collect();
        let rows = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
        Self { names, rows }
    }

    fn get(&self, row: usize, name: &str) -> f64 {
        self.rows[row][self.names.iter().position(|known| *known == name).unwrap()]
    }

    fn vector(&self, row: usize, name: &str, len: usize) -> Vec<f64> {
        (0..len).map(|i| self.get(row, &format!("{name}{i}"))).collect()
    }
}

fn replay() -> (Run, Locomotion<Recording>) {
    let run = Run::read();
    let states = (0..run.rows.len()).map(|row| [run.vector(row, "qpos", 6), run.vector(row, "qvel", 6)]).collect();
    let env = Locomotion::new(task("a/hopper").unwrap(), Recording { states, row: 0 }).unwrap();
    (run, env)
}

/// Every observation, reward and the step of the fall, given MuJoCo's states.
#[test]
fn observations_rewards_and_health_are_gymnasiums() {
    let (run, mut env) = replay();
    let (mut obs, mut reward) = (vec![0.0; 11], vec![0.0; 3]);
    env.reset(0, &mut obs).unwrap();
    for row in 1.. {
        let action: Vec<f32> = run.vector(row, "u", 3).iter().map(|&u| u as f32).collect();
        let outcome = env.step(&action, &mut obs, &mut reward).unwrap();
        close(&obs, &run.vector(row, "obs", 11));
        let wanted = ["A_safety", "A_velocity", "A_control"].map(|name| run.get(row, name));
        close(&reward, &wanted);
        assert_eq!(outcome == Outcome::Terminated, run.get(row, "terminated") == 1.0, "row {row}");
        if outcome != Outcome::Running {
            assert_eq!(row, 22);
            assert_eq!(reward[0], 0.0);
            break;
        }
    }
}

fn close(got: &[f32], wanted: &[f64]) {
    assert_eq!(got.len(), wanted.len());
    for (got, wanted) in got.iter().zip(wanted) {
        assert!((f64::from(*got) - wanted).abs() <= 1e-6 * (1.0 + wanted.abs()), "{got} against {wanted}");
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn same(got: &[f64], wanted: &Value, what: &str) {
    for (got, wanted) in got.iter().zip(numbers(wanted)) {
        assert!((got - wanted).abs() < 1e-12, "{what}: {got} against {wanted}");
    }
}

#[test]
fn the_hopper_is_mujocos_compiled_model() {
    let model: Value = serde_json::from_str(include_str!("data/model_gym_hopper.json")).unwrap();
    let hopper = robot::hopper();
    same(&[hopper.total_mass(), hopper.timestep], &serde_json::json!([model["total_mass"], model["timestep"]]), "mass");
    same(&hopper.initial_qpos, &model["qpos0"], "qpos0");
    for (body, wanted) in hopper.bodies.iter().zip(model["bodies"].as_array().unwrap().iter().skip(1)) {
        same(&[body.inertial.mass], &serde_json::json!([wanted["mass"]]), &body.name);
        same(&body.inertial.moments, &wanted["inertia"], &body.name);
        same(&body.inertial.com, &wanted["ipos"], &body.name);
        same(&body.inertial.quat, &wanted["iquat"], &body.name);
        same(&body.pos, &wanted["pos"], &body.name);
    }
    for (index, joint) in hopper.joints.iter().enumerate() {
        let (wanted, dof) = (&model["joints"][index], &model["dofs"][index]);
        same(&joint.axis, &wanted["axis"], &joint.name);
        same(&joint.anchor, &wanted["pos"], &joint.name);
        same(&joint.range.unwrap_or_default(), &wanted["range"], &joint.name);
        same(&joint.softness.solref, &wanted["solref"], &joint.name);
        same(&joint.softness.solimp, &wanted["solimp"], &joint.name);
        same(&[joint.damping, joint.armature], &serde_json::json!([dof["damping"], dof["armature"]]), &joint.name);
    }
    for (geom, wanted) in hopper.geoms.iter().zip(model["geoms"].as_array().unwrap()) {
        same(&geom.pos, &wanted["pos"], &geom.name);
        same(&geom.quat, &wanted["quat"], &geom.name);
        same(&geom.friction, &wanted["friction"], &geom.name);
        same(&geom.softness.solimp, &wanted["solimp"], &geom.name);
        same(&[geom.margin, f64::from(geom.condim)], &serde_json::json!([wanted["margin"], wanted["condim"]]), "geom");
    }
}

#[test]
fn the_same_pairs_may_collide() {
    let model: Value = serde_json::from_str(include_str!("data/model_gym_hopper.json")).unwrap();
    let hopper = robot::hopper();
    let n = hopper.geoms.len();
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).filter(|&(a, b)| hopper.collide(a, b));
    let named: Vec<_> = pairs.map(|(a, b)| [&hopper.geoms[a].name, &hopper.geoms[b].name].map(String::clone)).collect();
    assert_eq!(serde_json::json!(named), model["collidable_pairs"]);
    assert!((0..n).all(|a| (0..n).all(|b| hopper.collide(a, b) == hopper.collide(b, a))));
}
