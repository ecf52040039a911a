//! Every example runs, for a few hundred steps. (`cargo test -p copq-examples` builds them first.)

use std::path::PathBuf;
use std::process::Command;

/// Runs an example and returns what it printed.
fn run(name: &str, arguments: &[&str]) -> String {
    let mut path: PathBuf = std::env::current_exe().unwrap();
    path.pop();
    path.pop();
    let path = path.join("examples").join(name);
    assert!(path.exists(), "{} is not there; run `cargo test -p copq-examples`", path.display());
    let output = Command::new(path).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    assert!(output.status.success(), "{name} {arguments:?}: {}", text(output.stderr));
    text(output.stdout)
}

/// Runs a training program twice, the second time as a resumed run, and looks at its policy; returns its metrics' names.
fn train(name: &str, arguments: &[&str], start: &str, halves: [&str; 2]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let out = out.to_str().unwrap();
    let cadence = ["--eval-every", halves[0], "--eval-episodes", "1", "--log-every", "20"];
    let fresh = ["--out", out, "--steps", halves[0], "--start-steps", start];
    run(name, &[arguments, &cadence, &fresh].concat());
    run(name, &["--resume", out, "--steps", halves[1]]);
    let film = folder.path().join("rollout.gif");
    run("rollout", &[out, "--steps", "3", "--out", film.to_str().unwrap()]);
    let metrics = std::fs::read_to_string(PathBuf::from(out).join("metrics.csv")).unwrap();
    metrics.lines().next().unwrap().to_owned()
}

#[test]
fn td3() {
    for arguments in [&[][..], &["--projection", "independent-min"], &["--order", "vsc", "--gaussian"]] {
        assert!(train("td3", arguments, "150", ["180", "200"]).contains("critic_loss/safety"));
    }
}

#[test]
fn redq() {
    assert!(train("redq", &[], "280", ["283", "285"]).contains("q_spread/safety"));
    train("redq", &["--gaussian"], "280", ["281", "282"]);
    assert!(train("redq", &["--sac"], "280", ["281", "282"]).contains("actor/temperature"));
}

#[test]
fn sac_lagrangian() {
    for method in ["cop-cal", "cal", "cal-original", "saclag-ucb", "sac-lagrangian", "sac-pid"] {
        let metrics = train("sac_lagrangian", &["--method", method], "150", ["200", "240"]);
        for name in ["multiplier/cost", "multiplier_effective/cost", "cost_violation/cost", "actor/temperature"] {
            assert!(metrics.contains(name), "{method}: {metrics}");
        }
    }
}

#[test]
fn swap_projection() {
    let folder = tempfile::tempdir().unwrap();
    let table = run("swap_projection", &["--steps", "120", "--out", folder.path().to_str().unwrap()]);
    for name in copq::projection::names() {
        assert!(table.contains(&format!("| {name} | 1 |")), "{table}");
    }
    for file in ["table.md", "curves.svg", "curves.png"] {
        assert!(folder.path().join(file).exists(), "no {file}");
    }
}

#[test]
fn custom_env() {
    assert!(run("custom_env", &["400"]).contains("safety, progress"));
}

#[test]
fn custom_projection() {
    assert!(run("custom_projection", &["200"]).contains("velocity"));
}
