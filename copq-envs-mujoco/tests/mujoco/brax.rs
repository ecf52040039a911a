//! How near preset `Paper` on MuJoCo 3.17.0 is to Brax itself, whose runs were recorded in single
//! precision.
//!
//! The robots and conventions are the same, the solver of contacts and limits is not. `cargo test
//! -p copq-envs-mujoco --features mujoco-rs --test mujoco brax -- --nocapture --test-threads 1`
//! prints more than DESIGN.md quotes.

use crate::support::{ROBOTS, Replay, Table, largest, own_data, task};
use copq::Outcome;
use copq_envs::robot::Preset;
use copq_envs::{Physics, RobotSpec, Task};
use copq_envs_mujoco::mujoco_rs::physics;

/// A step that begins and ends this high above the floor (m) touches nothing,
const ROOM: f64 = 0.01;
/// and one that begins and ends this far inside of its joints' limits (rad) meets none: joints turn
/// by a few rad/s.
const SLACK: f64 = 0.1;

/// What pushes the robot during a step beside gravity, its motors and springs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Situation {
    Free,
    Limit,
    Contact,
}

impl Situation {
    /// The worse of a step's two ends, in Brax's run.
    fn of_step(robot: &RobotSpec, table: &Table, row: usize) -> Self {
        let ends = [row - 1, row].map(|row| table.vector(row, "qpos"));
        if ends.iter().any(|qpos| height(robot, qpos) < ROOM) {
            Self::Contact
        } else if ends.iter().any(|qpos| at_a_limit(robot, qpos)) {
            Self::Limit
        } else {
            Self::Free
        }
    }
}

/// Height of the lowest point that can touch the floor (m).
fn height(robot: &RobotSpec, qpos: &[f64]) -> f64 {
    let mut robot = robot.clone();
    let floor = robot.geoms.iter().position(|geom| geom.body.is_none()).unwrap();
    let touching: Vec<_> =
        (0..robot.geoms.len()).filter(|&geom| robot.collide(geom, floor)).collect();
    robot.geoms = touching.iter().map(|&geom| robot.geoms[geom].clone()).collect();
    let segments = robot.segments(&robot.body_poses(qpos));
    let ends = segments.iter().flat_map(|segment| segment.ends.map(|[_, _, z]| z - segment.radius));
    ends.fold(f64::INFINITY, f64::min)
}

fn at_a_limit(robot: &RobotSpec, qpos: &[f64]) -> bool {
    let mut rest = qpos;
    robot.joints.iter().any(|joint| {
        let (own, later) = rest.split_at(joint.kind.nq());
        rest = later;
        joint.range.is_some_and(|[low, high]| own[0] < low + SLACK || own[0] > high - SLACK)
    })
}

/// Largest differences from Brax after a step.
#[derive(Clone, Copy, Debug)]
struct Apart {
    qpos: f64,
    qvel: f64,
    obs: f64,
    /// Of the velocity that is the reward (m/s).
    velocity: f64,
}

impl Apart {
    fn after(replay: &Replay, task: &Task, table: &Table, row: usize) -> Self {
        let obs: Vec<f64> = replay.obs.iter().map(|&value| f64::from(value)).collect();
        let velocity =
            task.objectives.iter().position(|objective| objective.name == "velocity").unwrap();
        let mut qvel = vec![0.0; task.robot.nv()];
        replay.env.physics().qvel(&mut qvel);
        Self {
            qpos: largest(replay.env.qpos(), &table.vector(row, "qpos")),
            qvel: largest(&qvel, &table.vector(row, "qvel")),
            obs: largest(&obs, &table.vector(row, "obs")),
            velocity: (f64::from(replay.reward[velocity]) - table.get(row, "velocity").unwrap())
                .abs(),
        }
    }
}

fn recorded(robot: &str) -> (Task, Table) {
    (task(&format!("a/{robot}"), Preset::Paper), own_data(&format!("brax_{robot}_rollout")))
}

/// Median and largest.
fn summary(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[values.len() - 1]]
}

fn written([median, largest]: [f64; 2]) -> String {
    format!("{median:.0e} ({largest:.0e})")
}

/// Every step of Brax's run by itself, from Brax's state. The largest error of qpos in each
/// situation is a bound, with some room: what no contact and no limit disturbs agrees as well as
/// single precision can.
#[test]
fn single_steps() {
    println!(
        "| robot | during the step | steps | qpos | qvel | observation | velocity reward \
         |\n|---|---|--:|--:|--:|--:|--:|"
    );
    for robot in ROBOTS {
        let (task, table) = recorded(robot);
        let steps: Vec<_> = (1..table.len())
            .map(|row| {
                let mut replay = Replay::new(physics, &task, &table, row - 1);
                let ends = replay.step(&table, row) == Outcome::Terminated;
                assert_eq!(ends, table.get(row, "done") == Some(1.0), "{robot}, row {row}");
                (
                    Situation::of_step(&task.robot, &table, row),
                    Apart::after(&replay, &task, &table, row),
                )
            })
            .collect();
        for (situation, bound) in
            [Situation::Free, Situation::Limit, Situation::Contact].into_iter().zip(bounds(robot))
        {
            let of = |error: fn(&Apart) -> f64| -> Vec<f64> {
                steps.iter().filter(|step| step.0 == situation).map(|step| error(&step.1)).collect()
            };
            let qpos = of(|apart| apart.qpos);
            if qpos.is_empty() {
                continue;
            }
            let columns = [
                qpos.clone(),
                of(|apart| apart.qvel),
                of(|apart| apart.obs),
                of(|apart| apart.velocity),
            ];
            let columns = columns.map(|values| written(summary(values))).join(" | ");
            println!("| {robot} | {situation:?} | {} | {columns} |", qpos.len());
            let [_, worst] = summary(qpos);
            assert!(worst < bound, "{robot}, {situation:?}: {worst}");
        }
    }
}

/// Largest error of qpos that a step may have: free, at a limit, in contact.
fn bounds(robot: &str) -> [f64; 3] {
    match robot {
        "hopper" => [1e-5, 2e-4, 3e-3],
        "walker2d" => [1e-5, 0.1, 0.2],
        "halfcheetah" => [1e-5, 1e-3, 0.5],
        "ant" => [1e-5, 2e-3, 3.0],
        _ => [1e-5, 1e-5, 0.2],
    }
}

/// The same actions from the same start. Where contacts are chaotic even the step on which the
/// robot falls is another.
#[test]
fn rollouts() {
    const AFTER: [usize; 5] = [1, 5, 10, 20, 40];
    println!(
        "| robot | after 1 step | 5 | 10 | 20 | 40 | unhealthy first, Brax | here \
         |\n|---|--:|--:|--:|--:|--:|--:|--:|"
    );
    for robot in ROBOTS {
        let (task, table) = recorded(robot);
        let mut replay = Replay::new(physics, &task, &table, 0);
        let mut errors = vec![0.0];
        let mut end = None;
        for row in 1..table.len() {
            let outcome = replay.step(&table, row);
            end = end.or((outcome == Outcome::Terminated).then_some(row));
            errors.push(Apart::after(&replay, &task, &table, row).qpos);
        }
        let braxs = (1..table.len()).find(|&row| table.get(row, "done") == Some(1.0));
        let columns = AFTER.map(|step| format!("{:.0e}", errors[step])).join(" | ");
        println!("| {robot} | {columns} | {} | {} |", named(braxs), named(end));
        let bounds = match robot {
            "hopper" => [1e-5, 1e-3],
            "walker2d" => [1e-2, 1.0],
            "halfcheetah" => [1e-6, 1.0],
            "ant" => [2e-2, 1.0],
            _ => [1e-6, 1e-5],
        };
        assert!(errors[1] < bounds[0] && errors[10] < bounds[1], "{robot}: {errors:?}");
        assert!(
            end == braxs || !["hopper", "halfcheetah", "humanoid"].contains(&robot),
            "{robot}: {end:?}"
        );
    }
}

fn named(step: Option<usize>) -> String {
    step.map_or("never".into(), |step| step.to_string())
}
