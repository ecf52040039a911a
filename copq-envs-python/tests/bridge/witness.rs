//! The same actions give the same numbers, bit for bit, through the bridge and in Python itself.

use std::process::Command;

use copq::{Env, Outcome, Rng, check_env};
use copq_envs_python::{Options, PythonEnv};

use crate::support::{data, python};

const STEPS: usize = 1_000;

/// Six environments of the three packages.
const TASKS: [&str; 6] = [
    "gymnasium:Pendulum-v1",
    "gymnasium:Hopper-v5",
    "mo-gymnasium:mo-hopper-v5",
    "mo-gymnasium:mo-mountaincarcontinuous-v0",
    "safety-gymnasium:SafetyHopperVelocity-v1",
    "safety-gymnasium:SafetyPointGoal1-v0",
];

fn make(task: &str) -> Option<PythonEnv> {
    let options = Options { python: Some(python(task)?), ..Options::default() };
    Some(PythonEnv::new(task, &options).unwrap())
}

/// Every number that a thousand seeded actions show, episode after episode, and the actions.
fn play(env: &mut PythonEnv) -> (Vec<f32>, Vec<f32>) {
    let spec = env.spec().clone();
    let mut rng = Rng::with_stream(3, 1);
    let mut obs = vec![0.0; spec.obs_len];
    let mut reward = vec![0.0; spec.objectives.len()];
    let mut seen = Vec::new();
    let mut actions = Vec::new();
    let mut episode = 0;
    env.reset(episode, &mut obs).unwrap();
    seen.extend(&obs);
    for _ in 0..STEPS {
        let action: Vec<f32> = std::iter::zip(&spec.action_low, &spec.action_high)
            .map(|(&low, &high)| rng.uniform_in(low.into(), high.into()) as f32)
            .collect();
        let outcome = env.step(&action, &mut obs, &mut reward).unwrap();
        seen.extend(&obs);
        seen.extend(&reward);
        actions.extend(action);
        if outcome != Outcome::Running {
            episode += 1;
            env.reset(episode, &mut obs).unwrap();
            seen.extend(&obs);
        }
    }
    (seen, actions)
}

#[test]
fn a_thousand_steps_are_pythons_own() {
    for task in TASKS {
        let Some(mut env) = make(task) else { continue };
        let (seen, actions) = play(&mut env);
        let (package, id) = task.split_once(':').unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("actions");
        let bytes: Vec<u8> = actions.iter().flat_map(|action| action.to_le_bytes()).collect();
        std::fs::write(&file, bytes).unwrap();
        let output = Command::new(python(task).unwrap())
            .arg(format!("{}/play.py", data()))
            .args([&package.replace('-', "_"), id, "{}"])
            .arg(&file)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let (wanted, _) = output.stdout.as_chunks::<4>();
        assert!(wanted.len() > STEPS, "{task}");
        assert_eq!(wanted.len(), seen.len(), "{task}");
        let first =
            wanted.iter().zip(&seen).position(|(wanted, seen)| *wanted != seen.to_le_bytes());
        assert_eq!(first, None, "{task}: the first number that differs");
    }
}

#[test]
fn each_keeps_the_contract_of_environments() {
    for task in TASKS {
        let Some(python) = python(task) else { continue };
        let kwargs = r#"{"max_episode_steps": 100}"#.to_owned();
        let options = Options { python: Some(python), kwargs, ..Options::default() };
        let mut env = PythonEnv::new(task, &options).unwrap();
        let report = check_env(&mut env).unwrap();
        assert!(report.lengths.iter().all(|&length| length <= 100), "{task}: {report}");
        assert!(!report.saves, "{task}");
    }
}

#[test]
fn what_an_environment_says_of_itself_is_its_description() {
    let Some(env) = make("mo-gymnasium:mo-hopper-v5") else { return };
    let spec = env.spec();
    assert_eq!(spec.names(), ["reward.0", "reward.1", "reward.2"]);
    assert_eq!((spec.obs_len, spec.action_len(), spec.horizon), (11, 3, 1000));
    assert_eq!((&spec.action_low, &spec.action_high), (&vec![-1.0; 3], &vec![1.0; 3]));
    assert!(spec.versions.as_ref().unwrap().starts_with("Python 3."));
    let Some(env) = make("gymnasium:Pendulum-v1") else { return };
    assert_eq!((env.spec().action_low[0], env.spec().horizon), (-2.0, 200));
    let Some(env) = make("safety-gymnasium:SafetyHopperVelocity-v1") else { return };
    assert_eq!(env.spec().names(), ["cost", "reward"]);
    assert_eq!((env.spec().limit(0), env.spec().limit(1)), (Some(25.0), None));
}
