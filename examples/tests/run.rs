//! Every example runs, for a few hundred steps. (`cargo test -p copq-examples` builds them first.)

use std::path::PathBuf;
use std::process::{Command, Output};

use copq::{Env, Learner, Method};
use copq_candle::Candle;

/// An example's program.
fn path(name: &str) -> PathBuf {
    let mut path: PathBuf = std::env::current_exe().unwrap();
    path.pop();
    path.pop();
    let path = path.join("examples").join(name);
    assert!(path.exists(), "{} is not there; run `cargo test -p copq-examples`", path.display());
    path
}

/// Runs an example for so many steps.
fn example(name: &str, steps: &str) -> Output {
    Command::new(path(name)).arg(steps).env("RUST_BACKTRACE", "0").output().unwrap()
}

/// What it prints.
fn run(name: &str, steps: &str) -> String {
    let output = example(name, steps);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    assert!(output.status.success(), "{name} {steps}: {}", text(output.stderr));
    text(output.stdout)
}

#[test]
fn methods() {
    assert!(run("td3", "200").contains("after 200 steps: 10 episodes"));
    assert!(run("redq", "30").contains("velocity"));
    assert!(run("sac_lagrangian", "200").contains("the limit is"));
    assert!(run("ppo", "400").contains("the limit is"));
}

#[test]
fn swap_projection() {
    let table = run("swap_projection", "120");
    for name in copq::projection::names() {
        assert!(table.contains(&format!("{name:16} ")), "{table}");
    }
}

#[test]
fn your_own() {
    assert!(run("custom_env", "400").contains("progress"));
    assert!(run("custom_projection", "200").contains("velocity"));
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(path("inspect_bound")).current_dir(folder.path()).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let drawn = std::fs::read_to_string(folder.path().join("bound.svg")).unwrap();
    assert!(printed.contains("factor, safety first") && drawn.contains("extremum"), "{printed}");
    assert!(run("custom_network", "120").contains("with layer normalisation: 10 episodes"));
}

#[test]
fn runs_are_compared_and_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let compare = || {
        let mut command = Command::new(path("compare"));
        let output = command.arg("100").current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8(output.stderr).unwrap());
        String::from_utf8(output.stdout).unwrap()
    };
    let first = compare();
    assert!(first.contains("| scalarised-min | 3 | 100 |"), "{first}");
    assert!(first.contains("higher (95 %, three seeds each)"), "{first}");
    assert_eq!(compare(), first);
    assert!(folder.path().join("runs/compare/compare.svg").exists());
}

#[test]
fn act() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("policy.safetensors");
    let env = copq_envs_rapier::make("a/hopper").unwrap();
    let learner = Learner::new(Method::cop_td3(), env.spec(), &Candle::default(), 0).unwrap();
    learner.save_policy(&file).unwrap();
    let printed = run("act", file.to_str().unwrap());
    let first = "a/hopper by cop-td3, which put safety, velocity, control first\n";
    assert!(printed.starts_with(first) && printed.contains("an action takes"), "{printed}");
    let none = Command::new(path("act")).output().unwrap();
    let error = String::from_utf8(none.stderr).unwrap();
    assert!(error.contains("the argument: wanted a policy's file"), "{error}");
}

#[test]
fn a_wrong_number_is_a_readable_error() {
    let output = example("custom_env", "many");
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && error.contains("the argument"), "{error}");
    assert!(error.contains("steps to train for, such as 20000"), "{error}");
}
