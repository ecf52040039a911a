//! The program on Python environments, with the interpreter that scripts/python-worlds.sh
//! makes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::{copq, printed, refused, wait_until, well, words};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../copq-envs-python/tests/data");
const TASK: &str = "gymnasium:copq/Faulty-v0";

fn python() -> Option<PathBuf> {
    let usual = concat!(env!("CARGO_MANIFEST_DIR"), "/../third_party/gymnasium/bin/python");
    let python = std::env::var_os("COPQ_TEST_PYTHON").map_or(usual.into(), PathBuf::from);
    if !python.exists() {
        writeln!(
            std::io::stderr(),
            "SKIPPED: there is no {} (scripts/python-worlds.sh)",
            python.display()
        )
        .unwrap_or_default();
        return None;
    }
    Some(python)
}

/// A tiny run in a world with a fault, or with none.
fn train(python: &Path, out: &Path, fault: &str, more: &[&str]) -> Command {
    let mut command = copq();
    command.args(["train", "td3", "--task", TASK, "--python"]).arg(python).arg("--out").arg(out);
    command.args(["--import", &format!("{DATA}/copq_faulty.py")]);
    command.args(["--env-kwargs", &format!(r#"{{"fault": "{fault}"}}"#)]);
    let evaluations = if fault == "none" { "100" } else { "0" };
    command.args(["--eval-every", evaluations, "--eval-episodes", "1", "--log-every", "50"]);
    command.args(["--set", "start_steps=50", "--set", "networks.hidden=[8]", "--set", "batch=8"]);
    command.args(more);
    command
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

/// Processes that have a text in their command line.
fn running(text: &str) -> usize {
    let Ok(processes) = std::fs::read_dir("/proc") else { return 0 };
    let lines = processes.flatten().filter_map(|process| {
        let line = std::fs::read(process.path().join("cmdline")).ok()?;
        Some(String::from_utf8_lossy(&line).into_owned())
    });
    lines.filter(|line| line.contains(text)).count()
}

#[test]
fn a_run_goes_on_exactly_but_for_its_episode() {
    let Some(python) = python() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let [whole, halves] = ["whole", "halves"].map(|name| temporary.path().join(name));
    well(&mut train(&python, &whole, "none", &["--steps", "300"]));
    // Episodes take ten steps, so that none is cut here.
    well(&mut train(&python, &halves, "none", &["--steps", "150"]));
    let resumed = well(copq().arg("resume").arg(&halves).args(["--steps", "300"]));
    assert!(words(&resumed).contains("a new episode"), "{}", words(&resumed));
    for name in ["evaluations.csv", "metrics.csv", "policy.safetensors"] {
        assert!(read(&whole, name) == read(&halves, name), "{name}");
    }
    let config = String::from_utf8(read(&whole, "config.toml")).unwrap();
    assert!(config.contains("on_resume = \"new_episode\""), "{config}");
    assert!(config.contains("versions = \"Python 3"), "{config}");
    // A run like one of other versions is of its own world's.
    let twin = temporary.path().join("twin");
    let versions = config.lines().find(|line| line.starts_with("versions")).unwrap();
    let old = config.replace(versions, "versions = \"Python 2.7\"");
    std::fs::write(whole.join("config.toml"), old).unwrap();
    let mut like = copq();
    well(like.args(["train", "--steps", "50", "--like"]).arg(&whole).arg("--out").arg(&twin));
    let config = String::from_utf8(read(&twin, "config.toml")).unwrap();
    assert!(config.contains(versions), "{config}");
    // In mid-episode it goes on, too.
    let cut = temporary.path().join("cut");
    well(&mut train(&python, &cut, "none", &["--steps", "153"]));
    well(copq().arg("resume").arg(&cut).args(["--steps", "200"]));
    let evaluated = String::from_utf8(read(&cut, "evaluations.csv")).unwrap();
    let steps: Vec<_> = evaluated.lines().skip(1).filter_map(|row| row.split(',').next()).collect();
    assert_eq!(steps, ["0", "100", "200"]);
}

#[test]
fn what_has_been_learned_is_shown_and_evaluated() {
    let Some(python) = python() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    well(&mut train(&python, &run, "none", &["--steps", "100", "--objectives", "score"]));
    let table = printed(copq().args(["evaluate", "--episodes", "2"]).arg(&run));
    assert!(table.contains("| score | 10.0 |"), "{table}");
    well(copq().args(["rollout", "--steps", "7"]).arg(&run));
    assert!(read(&run, "rollout.gif").starts_with(b"GIF89a"));
}

#[test]
fn a_run_is_found_again_from_elsewhere_and_by_others() {
    let Some(python) = python() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let project = temporary.path();
    std::fs::copy(format!("{DATA}/copq_faulty.py"), project.join("mine.py")).unwrap();
    let tiny = ["--set", "start_steps=50", "--set", "networks.hidden=[8]", "--eval-every", "0"];
    let train = |more: &[&str]| {
        let mut command = copq();
        command.args(["train", "td3", "--task", TASK, "--steps", "60"]).current_dir(project);
        command.args(tiny).args(["--import", "mine.py"]).args(more);
        command
    };
    let python_words = ["--python", python.to_str().unwrap()];
    well(train(&["--out", "run"]).args(python_words));
    let elsewhere = project.join("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    let there = |words: &[&str]| well(copq().args(words).current_dir(&elsewhere));
    there(&["evaluate", "../run", "--episodes", "1"]);
    there(&["resume", "../run", "--steps", "70"]);
    // Other arguments are another folder, and a run like it on a robot of ours has nothing of it.
    let kwargs = r#"{ "fault":  "none" }"#;
    well(train(&["--env-kwargs", kwargs]).args(python_words));
    let usual = project.join("runs/td3-gymnasium-copq-Faulty-v0-scalarised-min-fault---none");
    assert!(
        std::fs::read_dir(project.join("runs"))
            .unwrap()
            .flatten()
            .any(|folder| folder.path().to_string_lossy().starts_with(&*usual.to_string_lossy())),
        "{:?}",
        std::fs::read_dir(project.join("runs")).unwrap().flatten().collect::<Vec<_>>()
    );
    let like = ["train", "--like", "../run", "--task", "gym/hopper", "--out", "../like"];
    there(&like);
    let config = String::from_utf8(read(&project.join("like"), "config.toml")).unwrap();
    assert!(config.contains("rapier") && !config.contains("ython"), "{config}");
    let mut resume = copq();
    resume.args(["resume", "--python", "python3", "--steps", "80"]).arg(project.join("like"));
    let said = refused(&mut resume);
    assert!(said.contains("wanted a Python environment"), "{said}");
}

#[test]
fn a_signal_to_everybody_is_a_stop() {
    let Some(python) = python() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    let mut command = train(&python, &run, "none", &["--steps", "1000000"]);
    let mut program = command.stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
    wait_until("it begins", || run.join("log.txt").exists());
    std::thread::sleep(Duration::from_secs(1));
    let mark = format!("{}", program.id());
    // The workers first: theirs are the children of the program.
    Command::new("pkill").args(["-TERM", "-P", &mark]).status().unwrap();
    Command::new("kill").args(["-TERM", &mark]).status().unwrap();
    let status = program.wait().unwrap();
    assert_eq!(status.code(), Some(75), "{status}");
    assert!(run.join("checkpoint.safetensors").exists());
}

#[test]
fn several_worlds_at_once_are_for_on_policy_methods() {
    let Some(python) = python() else { return };
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    let line = ["train", "ppo", "--task", TASK, "--envs", "2", "--threads", "2", "--python"];
    let import = format!("{DATA}/copq_faulty.py");
    let more = ["--eval-every", "0", "--set", "networks.hidden=[8]", "--steps", "2048", "--import"];
    well(copq().args(line).arg(&python).args(more).arg(import).arg("--out").arg(&run));
    well(copq().args(["resume", "--steps", "4096"]).arg(&run));
    let metrics = String::from_utf8(read(&run, "metrics.csv")).unwrap();
    assert_eq!(metrics.lines().count(), 3, "{metrics}");
}

#[test]
fn a_fault_ends_a_run_that_can_go_on() {
    let Some(python) = python() else { return };
    for (fault, said) in [
        ("raise", "step raised ValueError: the gripper is stuck"),
        ("kill", "its Python process ended during step (signal: 9"),
        ("nan", "number 0 of its reward after step 5: wanted a finite number"),
    ] {
        let temporary = tempfile::tempdir().unwrap();
        let run = temporary.path().join("run");
        let failed = train(&python, &run, fault, &["--steps", "60"]).output().unwrap();
        assert!(!failed.status.success(), "{fault}");
        let words = words(&failed);
        assert!(words.contains(said) && words.contains("after step 4"), "{fault}: {words}");
        assert!(words.contains("copq resume"), "{fault}: {words}");
        well(copq().args(["resume", "--on-env-error", "reset"]).arg(&run));
        let log = String::from_utf8(read(&run, "log.txt")).unwrap();
        assert!(log.contains("the episode counts as truncated"), "{fault}: {log}");
    }
}

#[test]
fn what_it_cannot_begin_with_leaves_no_folder() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    let complaint = |python: &Path, fault: &str, more: &[&str]| {
        let failed = train(python, &run, fault, more).output().unwrap();
        assert!(!failed.status.success() && !run.exists(), "{fault} {more:?}");
        words(&failed)
    };
    let nowhere = Path::new("/no/such/python");
    let said = complaint(nowhere, "none", &[]);
    assert!(said.contains("'/no/such/python': wanted a program"), "{said}");
    let said = complaint(nowhere, "none", &["--engine", "mujoco"]);
    assert!(said.contains("--engine, --preset: wanted none"), "{said}");
    let Some(python) = python() else { return };
    let said = complaint(&python, "discrete", &[]);
    assert!(said.contains("actions: wanted a Box of floats, got Discrete(3)"), "{said}");
    let said = complaint(&python, "none", &["--objectives", "a,b"]);
    assert!(said.contains("wanted 1 of them, for reward, got 2"), "{said}");
    let said = complaint(&python, "none", &["--limit", "heat=3"]);
    assert!(said.contains("unknown objective 'heat'; known: reward"), "{said}");
    let said = complaint(&python, "none", &["--weights", "1,2"]);
    assert!(said.contains("weights: wanted 1 of them, for reward, got 1,2"), "{said}");
    let said = refused(copq().args(["train", "--task", "a/hopper", "--python", "python3"]));
    assert!(said.contains("wanted a Python environment"), "{said}");
}

#[test]
fn python_ends_with_the_program_however_that_ends() {
    let Some(python) = python() else { return };
    for (fault, signal) in [("hang for ever", "KILL"), ("none", "KILL"), ("none", "INT")] {
        let temporary = tempfile::tempdir().unwrap();
        let run = temporary.path().join("run");
        // A module of this test's, so that its processes are known by its name.
        let module = temporary.path().join("nothing.py");
        std::fs::write(&module, "").unwrap();
        let mut command = train(&python, &run, fault, &["--steps", "1000000", "--import"]);
        command.arg(&module).stderr(Stdio::null()).stdout(Stdio::null());
        let mut program = command.spawn().unwrap();
        let processes = || running(&module.to_string_lossy());
        // The program, and of each world a worker and its guard.
        let worlds = if fault == "none" { 2 } else { 1 };
        let begun = || processes() == 1 + 2 * worlds && run.join("log.txt").exists();
        wait_until("it begins", begun);
        std::thread::sleep(Duration::from_millis(500));
        let id = program.id().to_string();
        Command::new("kill").args([&format!("-{signal}"), &id]).status().unwrap();
        wait_until("the program ends", || program.try_wait().unwrap().is_some());
        wait_until("nothing is left", || processes() == 0);
        if signal == "INT" {
            assert!(run.join("checkpoint.safetensors").exists());
        }
    }
}
