//! What goes wrong in Python is a clear error, soon, and leaves nothing behind.

use std::path::Path;
use std::time::{Duration, Instant};

use copq::{Env, Outcome, Result};
use copq_envs_python::{Options, PythonEnv};

use crate::support::{data, faulty, made, python, slow};

/// Plays until something ends or fails.
fn play(env: &mut PythonEnv) -> Result<(usize, Outcome)> {
    let mut obs = [0.0; 2];
    let mut reward = [0.0];
    env.reset(0, &mut obs)?;
    for step in 1.. {
        let outcome = env.step(&[0.5], &mut obs, &mut reward)?;
        if outcome != Outcome::Running {
            return Ok((step, outcome));
        }
    }
    unreachable!("episodes end")
}

/// Processes whose command line has a text, as Linux lists them.
fn running(text: &str) -> usize {
    let Ok(processes) = std::fs::read_dir("/proc") else { return 0 };
    let has_text = |folder: &Path| {
        let line = std::fs::read(folder.join("cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&line).contains(text)
    };
    processes.flatten().filter(|process| has_text(&process.path())).count()
}

/// Waits until there is none any more.
fn assert_gone(text: &str) {
    let deadline = Instant::now() + Duration::from_secs(10);
    while running(text) > 0 {
        assert!(Instant::now() < deadline, "still running: {text}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn faults_of_a_step_are_told_and_leave_nothing() {
    for (fault, words) in [
        ("raise", "step raised ValueError: the gripper is stuck"),
        ("exit", "step raised SystemExit: 3"),
        ("hang", "step took more than 5 s and was stopped"),
        ("hang for ever", "in misbehave"),
        ("child", "step took more than 5 s and was stopped"),
        ("segfault", "its Python process ended during step (signal: 11"),
        ("kill", "its Python process ended during step (signal: 9"),
        (
            "nan",
            "number 0 of its reward after step 5: wanted a finite number that fits f32, got NaN",
        ),
        ("infinite", "number 0 of its observation after step 5: wanted a finite number"),
        ("length", "observation: wanted 2 numbers, got 3 (shape (3,))"),
        ("huge", "observation: wanted 2 numbers, got 50000000"),
        ("vector", "reward: wanted 1 numbers, got 2"),
        ("nothing", "reward: wanted numbers, got None"),
        ("odd words", r"step raised ValueError: \udcff"),
        ("many words", "step raised ValueError: far too far too "),
        ("wait", "step raised ChildProcessError"),
    ] {
        let Some(env) = faulty(fault) else { return };
        let mut env = env.unwrap();
        let began = Instant::now();
        let error = play(&mut env).unwrap_err().to_string();
        assert!(error.len() < 25_000, "{fault}: {} letters", error.len());
        assert!(error.contains(words), "{fault}: {error}");
        assert!(error.starts_with("environment 'gymnasium:copq/Faulty-v0': "), "{error}");
        assert!(began.elapsed() < Duration::from_secs(20), "{fault}");
        drop(env);
        assert_gone(&format!(r#""fault":"{fault}""#));
    }
    assert_gone("sleep\u{0}1000");
}

#[test]
fn an_error_says_where_python_was() {
    let Some(env) = faulty("raise") else { return };
    let error = play(&mut env.unwrap()).unwrap_err().to_string();
    assert!(error.contains("copq_faulty.py:") && error.contains("in misbehave"), "{error}");
    assert!(!error.contains("<copq>"), "{error}");
    let error = play(&mut faulty("cause").unwrap().unwrap()).unwrap_err().to_string();
    assert!(
        error.contains("ValueError: no such joint") && error.contains("after KeyError: 'joint 3'")
    );
    let error = play(&mut faulty("cause of itself").unwrap().unwrap()).unwrap_err().to_string();
    assert!(error.contains("KeyError: 'joint 3'") && !error.contains("after"), "{error}");
    let error = play(&mut faulty("note").unwrap().unwrap()).unwrap_err().to_string();
    assert!(error.contains("ValueError: the gripper is stuck\nin scene 4"), "{error}");
    let error = play(&mut faulty("hang").unwrap().unwrap()).unwrap_err().to_string();
    assert!(error.contains("copq_faulty.py") && error.contains("misbehave"), "{error}");
}

#[test]
fn what_cannot_be_used_is_refused_at_the_start() {
    for (fault, words) in [
        ("discrete", "actions: wanted a Box of floats, got Discrete(3)"),
        ("unbounded", "actions: wanted finite bounds"),
        ("dictionary", "perhaps in gymnasium.wrappers.FlattenObservation"),
        ("enormous", "observations: wanted at most 1048576 numbers, got (4096, 4096, 3)"),
        ("start", "RuntimeError: no licence"),
    ] {
        let Some(env) = faulty(fault) else { return };
        let error = env.unwrap_err().to_string();
        assert!(error.contains(words), "{fault}: {error}");
        assert_gone(&format!(r#""fault":"{fault}""#));
    }
    let Some(env) = slow() else { return };
    let error = env.unwrap_err().to_string();
    assert!(error.contains("its start took more than 5 s and was stopped"), "{error}");
    let error = made("gymnasium:copq/Endless-v0", "none").unwrap().unwrap_err().to_string();
    assert!(error.contains("length of episodes: wanted a limit, got none"), "{error}");
}

/// An environment with these arguments.
fn with(task: &str, kwargs: String) -> Option<Result<PythonEnv>> {
    let options = Options {
        python: Some(python(task)?),
        kwargs,
        imports: vec![format!("{}/copq_faulty.py", data())],
        ..Options::default()
    };
    Some(PythonEnv::new(task, &options))
}

/// To the last bit; and the module sees no arguments of another program's.
#[test]
fn numbers_arrive_as_they_were_told() {
    let kwargs = r#"{"fault": "told", "number": 0.10567641159200747}"#.to_owned();
    let Some(env) = with("gymnasium:copq/Faulty-v0", kwargs) else { return };
    let error = env.unwrap_err().to_string();
    assert!(error.contains("RuntimeError: 0.10567641159200747 and []"), "{error}");
}

#[test]
fn what_a_world_registered_for_its_end_is_done() {
    let folder = tempfile::tempdir().unwrap();
    for task in ["copq/Faulty-v0", "copq/Endless-v0"] {
        let file = folder.path().join("simulator");
        let kwargs = format!(r#"{{"file": {file:?}}}"#);
        let Some(env) = with(&format!("gymnasium:{task}"), kwargs) else { return };
        assert_eq!(env.is_ok(), task == "copq/Faulty-v0", "{task}");
        assert!(file.exists() || env.is_err());
        drop(env);
        let deadline = Instant::now() + Duration::from_secs(10);
        while file.exists() {
            assert!(Instant::now() < deadline, "{task}: still there");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn a_seed_is_that_of_the_spaces_too() {
    let reset = || {
        let mut env = faulty("sampled")?.unwrap();
        let mut obs = [0.0; 2];
        env.reset(7, &mut obs).unwrap();
        Some(obs)
    };
    let Some(first) = reset() else { return };
    assert_eq!(reset(), Some(first));
}

#[test]
fn what_is_not_there_is_said_with_what_would_help() {
    let at = |python: &str, task: &str| {
        let options = Options { python: Some(python.into()), ..Options::default() };
        PythonEnv::new(task, &options).unwrap_err().to_string()
    };
    let error = at("/no/such/python", "gymnasium:Pendulum-v1");
    assert!(error.contains("'/no/such/python'") && error.contains("--python PATH"), "{error}");
    let error = at("/bin/true", "gymnasium:Pendulum-v1");
    assert!(error.contains("its Python process ended during its start"), "{error}");
    let Some(python) = python("gymnasium:Pendulum-v1") else { return };
    let python = python.to_string_lossy();
    let error = at(&python, "safety-gymnasium:SafetyHopperVelocity-v1");
    assert!(error.contains("pip install safety-gymnasium"), "{error}");
    let error = at(&python, "gymnasium:Pendulun-v1");
    assert!(error.contains("Pendulun") && error.contains("Did you mean"), "{error}");
}

#[test]
fn the_next_episode_goes_on_after_an_error() {
    // In the same process after an exception, in a new one after its end.
    for fault in ["raise", "kill", "hang"] {
        let Some(env) = made("gymnasium:copq/Once-v0", fault) else { return };
        let mut env = env.unwrap();
        assert!(play(&mut env).is_err(), "{fault}");
        let error = env.step(&[0.0], &mut [0.0; 2], &mut [0.0]).err().map(|e| e.to_string());
        if fault != "raise" {
            assert!(error.unwrap().contains("wanted a running episode"), "{fault}");
            assert!(play(&mut env).is_err(), "{fault}: the first episode of a new process");
            continue;
        }
        assert_eq!(play(&mut env).unwrap(), (10, Outcome::Truncated), "{fault}");
    }
}

#[test]
fn printing_disturbs_nothing() {
    let Some(env) = faulty("print") else { return };
    assert_eq!(play(&mut env.unwrap()).unwrap(), (10, Outcome::Truncated));
}

#[test]
fn children_and_threads_of_an_environment_are_its_own_affair() {
    for fault in ["fork", "thread"] {
        let Some(env) = faulty(fault) else { return };
        let mut env = env.unwrap();
        assert_eq!(play(&mut env).unwrap(), (10, Outcome::Truncated), "{fault}");
        let began = Instant::now();
        drop(env);
        assert!(began.elapsed() < Duration::from_secs(4), "{fault}");
    }
}

#[test]
fn a_seed_holds_for_pythons_own_generators() {
    let rewards = |env: &mut PythonEnv| {
        let mut reward = [0.0];
        env.reset(7, &mut [0.0; 2]).unwrap();
        (0..10)
            .map(|_| (env.step(&[0.0], &mut [0.0; 2], &mut reward).unwrap(), reward[0]).1)
            .collect()
    };
    let Some(env) = faulty("chance") else { return };
    let mut env = env.unwrap();
    let first: Vec<f32> = rewards(&mut env);
    assert_ne!(first[8], first[9]);
    assert_eq!(first, rewards(&mut env));
    // What it drew when it was made is the same in another process.
    assert_eq!(first, rewards(&mut faulty("chance").unwrap().unwrap()));
}

#[test]
fn wrappers_say_what_they_make_of_actions_and_rewards() {
    let counts = |name: &str| {
        let task = format!("gymnasium:copq/{name}-v0");
        let options = Options {
            python: Some(python(&task)?),
            imports: vec![format!("{}/copq_faulty.py", data())],
            ..Options::default()
        };
        let mut env = PythonEnv::new(&task, &options).unwrap();
        let mut reward = vec![0.0; env.spec().objectives.len()];
        env.reset(0, &mut [0.0; 2]).unwrap();
        let mut obs = [0.0; 2];
        env.step(&[0.5], &mut obs, &mut reward).unwrap();
        Some((obs[1], reward))
    };
    let Some(advised) = counts("Advised") else { return };
    assert_eq!(advised, (5.0, vec![1.0]));
    assert_eq!(counts("Parts").unwrap(), (0.5, vec![1.0, -1.0]));
    assert_eq!(counts("Added").unwrap(), (0.5, vec![0.0]));
}

#[test]
fn terminated_and_truncated_at_once_is_terminated() {
    let Some(env) = faulty("both") else { return };
    assert_eq!(play(&mut env.unwrap()).unwrap(), (5, Outcome::Terminated));
}

#[test]
fn a_picture_is_what_the_environment_draws() {
    let task = "gymnasium:copq/Faulty-v0";
    let options = Options {
        python: python(task),
        imports: vec![format!("{}/copq_faulty.py", data())],
        render: true,
        ..Options::default()
    };
    if options.python.is_none() {
        return;
    }
    let mut env = PythonEnv::new(task, &options).unwrap();
    assert_eq!(env.frames_per_second(), 20.0);
    env.reset(0, &mut [0.0; 2]).unwrap();
    env.step(&[0.0], &mut [0.0; 2], &mut [0.0]).unwrap();
    let picture = env.picture().unwrap();
    assert_eq!((picture.width, picture.height), (50, 30));
    assert_eq!(picture.rgb, vec![1; 3 * 50 * 30]);
}
