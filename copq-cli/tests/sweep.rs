//! A sweep of small runs: planned, trained, stopped and gone on with, and what it says of failures.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn sweep(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_copq"));
    command.arg("sweep").args(arguments).current_dir(folder).env("RUST_BACKTRACE", "0");
    command
}

fn text(output: &Output) -> String {
    let all = [output.stdout.clone(), output.stderr.clone()].concat();
    String::from_utf8(all).unwrap()
}

const TINY: &str = r#"
[all]
eval-every = 60
eval-episodes = 1
log-every = 20
checkpoint-every = 40
set = ["networks.hidden=[8,8]"]
"#;

fn write(folder: &Path, text: &str) {
    std::fs::write(folder.join("tiny.toml"), text.to_owned() + TINY).unwrap();
}

fn file(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

#[test]
fn a_grid_is_trained_once_and_as_copq_train_would() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    write(
        folder,
        r#"
exclude = [{ bound = "extremum", seed = 1 }]

[grid]
bound = ["cholesky", "extremum"]
seed = [0, 1]

[[arm]]
name = "short"
steps = 90
set = ["batch=8", "start_steps=40"]

[[include]]
method = "ppo"
task = "b/hopper"
steps = 128
set = ["steps_per_epoch=64"]
"#,
    );
    let plan = text(&sweep(folder, &["plan", "tiny.toml"]).output().unwrap());
    assert_eq!(plan.lines().count(), 4, "{plan}");
    assert!(plan.contains("copq train --bound cholesky --checkpoint-every 40"), "{plan}");
    let output = sweep(folder, &["run", "tiny.toml", "--jobs", "2"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert_eq!(status.matches("| done |").count(), 4, "{status}");
    let again = sweep(folder, &["run", "tiny.toml"]).output().unwrap();
    assert!(text(&again).starts_with("4 runs, 4 of them done"), "{}", text(&again));
    // The second run's line of the plan, typed by hand, leaves the same bytes.
    let line = plan.lines().nth(1).unwrap();
    let mut words = line.split_whitespace().skip(1);
    let run = folder.join(words.next().unwrap());
    let by_hand = Command::new(env!("CARGO_BIN_EXE_copq"))
        .args(words.skip(1))
        .args(["--out", "by-hand"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(by_hand.status.success(), "{}", text(&by_hand));
    for name in ["metrics.csv", "evaluations.csv", "checkpoint.safetensors"] {
        assert!(file(&run, name) == file(&folder.join("by-hand"), name), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_stopped_sweep_goes_on_to_the_same_bytes() {
    let temporary = tempfile::tempdir().unwrap();
    let run = |name: &str, wait: bool| {
        let folder = temporary.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        write(
            &folder,
            "[grid]\nseed = [0, 1]\nsteps = [400]\nset = [\"batch=8\"]\n[[arm]]\nset = [\"start_steps=40\"]\n",
        );
        let mut child = sweep(&folder, &["run", "tiny.toml", "--jobs", "2"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        if !wait {
            let begun = Instant::now();
            let runs = folder.join("runs/tiny");
            let has_begun = || {
                std::fs::read_dir(&runs).is_ok_and(|runs| {
                    runs.flatten().any(|run| run.path().join("checkpoint.safetensors").is_file())
                })
            };
            while !has_begun() {
                assert!(begun.elapsed() < Duration::from_secs(60), "no checkpoint");
                std::thread::sleep(Duration::from_millis(20));
            }
            let id = child.id().to_string();
            assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
            assert_eq!(child.wait().unwrap().code(), Some(75));
            child = sweep(&folder, &["run", "tiny.toml"]).stdout(Stdio::null()).spawn().unwrap();
        }
        assert!(child.wait().unwrap().success());
        let mut runs: Vec<_> = std::fs::read_dir(folder.join("runs/tiny"))
            .unwrap()
            .flatten()
            .map(|e| e.path())
            .collect();
        runs.sort();
        assert_eq!(runs.len(), 2, "{runs:?}");
        runs.iter().map(|run| file(run, "checkpoint.safetensors")).collect::<Vec<_>>()
    };
    assert!(run("whole", true) == run("stopped", false));
}

#[test]
fn mistakes_are_told_before_and_failures_after() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for (text_of_file, wanted) in [
        ("grid = 3", "invalid type"),
        ("", "wanted one run at least"),
        ("[grid]\nmethd = [\"td3\"]", "unexpected argument '--methd'"),
        ("[grid]\nmethod = [\"td4\"]", "invalid value 'td4'"),
        ("[grid]\nseed = [1, 1]", "wanted each run once"),
        ("[grid]\nout = [\"a\"]", "wanted it for the whole sweep"),
    ] {
        std::fs::write(folder.join("bad.toml"), text_of_file).unwrap();
        let output = sweep(folder, &["plan", "bad.toml"]).output().unwrap();
        assert!(!output.status.success() && text(&output).contains(wanted), "{}", text(&output));
    }
    // A task that the method does not suit shows when it is begun.
    write(folder, "[grid]\nmethod = [\"rcpo\"]\ntask = [\"a/hopper\"]\nsteps = [100]\n");
    let output = sweep(folder, &["run", "tiny.toml"]).output().unwrap();
    let words = text(&output);
    assert!(!output.status.success(), "{words}");
    assert!(words.contains("failed: ") && words.contains("a task with a cost"), "{words}");
}
