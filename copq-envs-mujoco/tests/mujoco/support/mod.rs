//! Golden data against an engine: recorded runs replayed, at the level of the engine and of the
//! environment.
#![allow(dead_code)]

#[path = "../../../../copq-envs/tests/all/support/table.rs"]
mod table;

mod engines;

use std::path::PathBuf;

use approx::abs_diff_eq;
use copq::{Env, Outcome, State};
use copq_envs::robot::{Preset, Senses};
use copq_envs::{Field, Locomotion, Options, Physics, Readings, RobotSpec, Task, task_with};
use copq_envs_mujoco::Mujoco;
pub use engines::{ENGINES, Make};
pub use table::Table;

pub const ROBOTS: [&str; 5] = ["hopper", "walker2d", "halfcheetah", "ant", "humanoid"];

/// Every task with recorded rewards.
pub const BENCHMARKS: [(&str, &str); 14] = [
    ("a", "hopper"),
    ("a", "walker2d"),
    ("a", "halfcheetah"),
    ("a", "ant"),
    ("a", "humanoid"),
    ("b", "hopper"),
    ("b", "walker2d"),
    ("b", "ant"),
    ("b", "humanoid"),
    ("gym", "hopper"),
    ("gym", "walker2d"),
    ("gym", "halfcheetah"),
    ("gym", "ant"),
    ("gym", "humanoid"),
];

/// A recorded run: `<robot>_rollout`, `<robot>_onestep`, `paper_<robot>_rollout`. `COPQ_GOLDEN`
/// names a folder with longer ones.
pub fn golden(name: &str) -> Table {
    std::env::var_os("COPQ_GOLDEN")
        .map_or_else(|| own_data(name), |folder| read(PathBuf::from(folder), name))
}

/// One of this crate's own tables.
pub fn own_data(name: &str) -> Table {
    read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data"), name)
}

fn read(folder: PathBuf, name: &str) -> Table {
    Table::parse(&std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap())
}

pub fn task(name: &str, preset: Preset) -> Task {
    let senses = if preset == Preset::GymV5 { Senses::Gymnasium } else { Senses::Standard };
    task_with(name, &Options { preset, senses, ..Options::default() }).unwrap()
}

/// The largest difference between two lists.
pub fn largest(got: &[f64], wanted: &[f64]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    got.iter().zip(wanted).map(|(got, wanted)| (got - wanted).abs()).fold(0.0, f64::max)
}

pub fn qpos(physics: &Mujoco) -> Vec<f64> {
    let mut qpos = vec![0.0; physics.dims().nq];
    physics.qpos(&mut qpos);
    qpos
}

pub fn qvel(physics: &Mujoco) -> Vec<f64> {
    let mut qvel = vec![0.0; physics.dims().nv];
    physics.qvel(&mut qvel);
    qvel
}

/// How far the engine is from the state in a row's columns of these names.
pub fn state_error(physics: &Mujoco, table: &Table, row: usize, columns: [&str; 2]) -> f64 {
    let [wanted_qpos, wanted_qvel] = columns.map(|name| table.vector(row, name));
    largest(&qpos(physics), &wanted_qpos).max(largest(&qvel(physics), &wanted_qvel))
}

/// The controls of a row's actions.
fn controls(robot: &RobotSpec, table: &Table, row: usize) -> Vec<f64> {
    let motors = table.vector(row, "u").into_iter().zip(&robot.actuators);
    motors.map(|(u, motor)| motor.range[1] * f64::from(u as f32)).collect()
}

/// Replays a run on the engine alone, from the given state; what `look` sees in every row from the
/// start on.
pub fn rollout<T>(
    make: Make,
    robot: &RobotSpec,
    table: &Table,
    [qpos, qvel]: [&[f64]; 2],
    mut look: impl FnMut(&mut Mujoco, usize) -> T,
) -> Vec<T> {
    let mut physics = make(robot).unwrap();
    physics.reset_to(qpos, qvel).unwrap();
    let mut seen = vec![look(&mut physics, 0)];
    for row in 1..table.len() {
        physics.step(&controls(robot, table, row), robot.frame_skip).unwrap();
        seen.push(look(&mut physics, row));
    }
    seen
}

/// Takes every recorded step by itself, from its own state; what `look` sees after each.
pub fn one_steps<T>(
    make: Make,
    robot: &RobotSpec,
    table: &Table,
    mut look: impl FnMut(&mut Mujoco, usize) -> T,
) -> Vec<T> {
    let mut physics = make(robot).unwrap();
    let steps = (0..table.len()).map(|row| {
        physics.reset_to(&table.vector(row, "qpos"), &table.vector(row, "qvel")).unwrap();
        physics.step(&controls(robot, table, row), robot.frame_skip).unwrap();
        look(&mut physics, row)
    });
    steps.collect()
}

/// Gymnasium's observation in double precision, from what the engine tells.
pub fn observation(physics: &mut Mujoco, task: &Task) -> Vec<f64> {
    let robot = &task.robot;
    let clip = task.robot.observation.clip;
    let mut seen = qpos(physics).split_off(robot.observation.skip);
    seen.extend(qvel(physics).iter().map(|velocity| velocity.clamp(-clip, clip)));
    for field in robot.observation.fields() {
        let mut values = vec![0.0; field.len(robot)];
        physics.read(field, &mut values).unwrap();
        match (robot.name.as_str(), field) {
            ("ant", Field::ContactForce) => {
                seen.extend(values.iter().map(|force| force.clamp(-1.0, 1.0)))
            }
            (_, Field::ActuatorForce) => seen.extend(&values[6..]),
            _ => seen.extend(values),
        }
    }
    seen
}

/// The largest error of every row of a recorded rollout.
pub fn rollout_errors(make: Make, robot: &RobotSpec, table: &Table) -> Vec<f64> {
    let start = [table.vector(0, "qpos"), table.vector(0, "qvel")];
    let start = [&start[0][..], &start[1][..]];
    rollout(make, robot, table, start, |physics, row| {
        state_error(physics, table, row, ["qpos", "qvel"])
    })
}

/// The largest error of every recorded single step.
pub fn one_step_errors(make: Make, robot: &RobotSpec, table: &Table) -> Vec<f64> {
    one_steps(make, robot, table, |physics, row| {
        state_error(physics, table, row, ["nqpos", "nqvel"])
    })
}

/// An environment on a recorded run.
pub struct Replay {
    pub env: Locomotion<Mujoco>,
    pub obs: Vec<f32>,
    pub reward: Vec<f32>,
}

impl Replay {
    /// At the state of a row.
    pub fn new(make: Make, task: &Task, table: &Table, row: usize) -> Self {
        let robot = &task.robot;
        let qpos = table.vector(row, "qpos");
        let mut physics = make(robot).unwrap();
        physics.reset_to(&qpos, &table.vector(row, "qvel")).unwrap();
        let mut readings = Readings::new(task.fields(), robot);
        readings.read(&mut physics).unwrap();
        // As if an episode had begun there.
        let mut state = State::default();
        state.put("phase", [1_u64]);
        state.put("steps", [0_u64]);
        state.put("place", robot.velocity_point.place(robot, &qpos, &readings));
        physics.save(state.child_mut("physics")).unwrap();
        let mut env = Locomotion::new(task.clone(), physics).unwrap();
        env.load(&state).unwrap();
        let obs = vec![0.0; env.spec().obs_len];
        let reward = vec![0.0; env.spec().objectives.len()];
        Self { env, obs, reward }
    }

    /// Takes a row's action; a recording goes on after the robot has fallen, and so must we.
    pub fn step(&mut self, table: &Table, row: usize) -> Outcome {
        let mut state = State::default();
        self.env.save(&mut state).unwrap();
        state.put("phase", [1u64]);
        self.env.load(&state).unwrap();
        let action: Vec<f32> = table.vector(row, "u").iter().map(|&u| u as f32).collect();
        self.env.step(&action, &mut self.obs, &mut self.reward).unwrap()
    }
}

/// A row's rewards of a task.
pub fn rewards(benchmark: &str, robot: &str, table: &Table, row: usize) -> Vec<f32> {
    let columns: &[&str] = match (benchmark, robot) {
        ("a", "halfcheetah") => &["A_velocity", "A_control"],
        ("a", _) => &["A_safety", "A_velocity", "A_control"],
        ("b", _) => &["B_cost", "B_reward"],
        _ => &["gym_reward"],
    };
    columns.iter().map(|name| table.get(row, name).unwrap() as f32).collect()
}

/// Numbers equal but for a relative tolerance, absolute below 1.
pub fn close<T: Copy + Into<f64>>(got: &[f32], wanted: &[T], tolerance: f64, what: &str) {
    assert_eq!(got.len(), wanted.len(), "{what}");
    for (i, (got, wanted)) in got.iter().zip(wanted).enumerate() {
        let got = f64::from(*got);
        let wanted = (*wanted).into();
        assert!(
            abs_diff_eq!(got, wanted, epsilon = tolerance * (1.0 + wanted.abs())),
            "{what}, number {i}: {got} against {wanted}"
        );
    }
}
