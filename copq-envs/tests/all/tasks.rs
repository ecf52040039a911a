//! The tasks' dimensions, objectives, limits and options.

use crate::support;

use approx::assert_abs_diff_eq;
use copq::Env;
use copq_envs::robot::{Noise, Preset, Senses};
use copq_envs::task::{Motion, Signal, SignalSum};
use copq_envs::{Field, Locomotion, Options, Readings, list_tasks, task, task_with, tasks};
use support::Still;

fn seen(robot: &str, preset: Preset, senses: Senses) -> usize {
    let options = Options { preset, senses, ..Options::default() };
    let task = task_with(&format!("a/{robot}"), &options).unwrap();
    task.robot.observation.len(&task.robot)
}

#[test]
fn observations_have_gymnasiums_and_braxs_lengths() {
    for (robot, gym, paper, joints, all) in [
        ("hopper", 11, 11, 11, 11),
        ("walker2d", 17, 17, 17, 17),
        ("halfcheetah", 17, 17, 17, 17),
        ("ant", 27, 27, 27, 105),
        ("humanoid", 348, 244, 45, 348),
    ] {
        assert_eq!(seen(robot, Preset::GymV5, Senses::Standard), gym);
        assert_eq!(seen(robot, Preset::Paper, Senses::Standard), paper);
        assert_eq!(seen(robot, Preset::GymV5, Senses::Joints), joints);
        assert_eq!(seen(robot, Preset::Paper, Senses::Joints), joints);
        assert_eq!(seen(robot, Preset::GymV5, Senses::Gymnasium), all);
    }
}

fn value(objective: &SignalSum, healthy: bool) -> f64 {
    let readings = Readings::default();
    let motion = Motion {
        healthy,
        velocity: [-3.0, 4.0],
        control: 2.0,
        motor_control: 0.32,
        readings: &readings,
    };
    objective.reward(&motion)
}

fn values(name: &str, options: &Options, healthy: bool) -> Vec<f64> {
    task_with(name, options)
        .unwrap()
        .objectives
        .iter()
        .map(|objective| value(objective, healthy))
        .collect()
}

/// Velocity (-3, 4) m/s, squared actions 2, squared controls 0.32.
#[test]
fn rewards_are_those_of_tables_1_and_c1() {
    let options = Options::default();
    assert_eq!(values("a/humanoid", &options, true), [5.0, -3.0, -2.0]);
    assert_eq!(values("a/humanoid", &options, false), [0.0, -3.0, -2.0]);
    assert_eq!(values("a/halfcheetah", &options, true), [-3.0, -2.0]);
    assert_eq!(values("b/humanoid", &options, true), [5.0, 5.0 - 3.75 - 0.1 * 0.32]);
    assert_eq!(values("b/ant", &options, false), [5.0, -3.0 - 0.5 * 0.32]);
    let weights = |name| {
        task(name).unwrap().objectives.iter().map(|objective| objective.weight).collect::<Vec<_>>()
    };
    assert_eq!(weights("a/humanoid"), [1.0, 5.0, 1.0]);
    assert_eq!(weights("a/walker2d"), [1.0, 1.0, 0.5]);
    assert_eq!(weights("a/halfcheetah"), [1.0, 1.0]);
    assert_eq!(weights("b/walker2d"), [0.0, 1.0]);
}

#[test]
fn options_choose_the_other_readings() {
    let all = Options {
        bonus: Some(Signal::Alive),
        control: Some(Signal::MotorControl),
        cost: Some(Signal::ForwardSpeed),
        limit: Some(1414.9),
        ..Options::default()
    };
    assert_eq!(values("a/humanoid", &all, false), [5.0, -3.0, -0.32]);
    assert_eq!(values("b/ant", &all, false)[0], 3.0);
    let signed = Options { cost: Some(Signal::Velocity), ..all.clone() };
    assert_eq!(values("b/ant", &signed, false)[0], -3.0);
    assert_eq!(task_with("b/humanoid", &all).unwrap().objectives[0].limit, Some(1414.9));
    let actions = Options { control: Some(Signal::Control), ..Options::default() };
    assert_eq!(values("b/humanoid", &actions, true)[1], 5.0 - 3.75 - 0.2);
}

#[test]
fn gymnasiums_reward_prices_contacts_and_braxs_does_not() {
    for name in ["gym/ant", "gym/humanoid"] {
        let terms = |preset| {
            let options = Options { preset, ..Options::default() };
            task_with(name, &options).unwrap().objectives[0].terms.len()
        };
        assert_eq!(terms(Preset::GymV5), terms(Preset::Paper) + 1, "{name}");
    }
}

/// The pose is Brax's, the coordinates and the noise are Gymnasium's.
#[test]
fn any_preset_can_start_as_the_paper_does() {
    let options = Options { start: Some(Preset::Paper), ..Options::default() };
    for name in tasks() {
        let moved = task_with(name, &options).unwrap().robot;
        let own = task(name).unwrap().robot;
        assert_eq!(moved.initial_qpos != own.initial_qpos, own.name == "ant", "{name}");
        assert_eq!(moved.reset_noise, own.reset_noise);
    }
    let ant = task_with("a/ant", &options).unwrap().robot;
    assert_eq!(
        ant.initial_qpos[2..],
        [0.55, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0]
    );
    assert_eq!(ant.reset_noise, [Noise::Uniform(0.1), Noise::Gaussian(0.1)]);
}

#[test]
fn quaternions_are_normalised_after_noise() {
    let options = Options { senses: Senses::Joints, ..Options::default() };
    let task = task_with("a/ant", &options).unwrap();
    let mut env = Locomotion::new(task.clone(), Still::of(&task.robot)).unwrap();
    let mut obs = vec![0.0; 27];
    for seed in 0..20 {
        env.reset(seed, &mut obs).unwrap();
        let norm: f64 = obs[1..5].iter().map(|&x| f64::from(x) * f64::from(x)).sum();
        assert_abs_diff_eq!(norm, 1.0, epsilon = 1e-6);
        assert_ne!(obs[1], 1.0);
    }
}

#[test]
fn an_engine_that_cannot_tell_a_field_is_refused_at_once() {
    let task = task("gym/ant").unwrap();
    assert_eq!(task.fields(), [Field::BodyPosition, Field::ContactForce]);
    let physics = Still { tells: vec![Field::BodyPosition], ..Still::of(&task.robot) };
    let error = Locomotion::new(task, physics).unwrap_err().to_string();
    assert!(
        error.contains("gym/ant reads") && error.contains("does not tell ContactForce"),
        "{error}"
    );
}

#[test]
fn the_table_lists_every_task() {
    let table = list_tasks(&Options::default()).unwrap();
    assert_eq!(table.lines().count(), tasks().len() + 1);
    let line = |name| table.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    assert_eq!(
        line("a/humanoid"),
        "a/humanoid         348      17  safety x 1, velocity x 5, control x 1"
    );
    assert_eq!(line("b/hopper"), "b/hopper            11       3  cost <= 740.2, reward x 1");
}

/// No field is read twice, and none that is not asked for.
#[test]
fn readings_hold_what_was_asked_for() {
    let robot = task("a/humanoid").unwrap().robot;
    let mut readings = Readings::new([Field::Inertia, Field::Velocity, Field::Inertia], &robot);
    let mut physics = Still { tells: vec![Field::Inertia, Field::Velocity], ..Still::of(&robot) };
    readings.read(&mut physics).unwrap();
    assert_eq!(
        [Field::Inertia, Field::Velocity, Field::BodyCentre].map(|field| readings.get(field).len()),
        [130, 78, 0]
    );
    assert_eq!(physics.asked, [Field::Inertia, Field::Velocity]);
}
