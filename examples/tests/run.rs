//! Every example runs, for a few hundred steps. (`cargo test -p copq-examples` builds them first.)

use std::path::PathBuf;
use std::process::Command;

/// An example's program.
fn path(name: &str) -> PathBuf {
    let mut path: PathBuf = std::env::current_exe().unwrap();
    path.pop();
    path.pop();
    let path = path.join("examples").join(name);
    assert!(path.exists(), "{} is not there; run `cargo test -p copq-examples`", path.display());
    path
}

/// Runs an example and returns what it printed.
fn run(name: &str, arguments: &[&str]) -> String {
    let output = Command::new(path(name)).args(arguments).output().unwrap();
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
    let start = format!("start_steps={start}");
    let fresh = ["--out", out, "--steps", halves[0], "--set", &start];
    run(name, &[arguments, &cadence, &fresh].concat());
    run(name, &["--resume", out, "--steps", halves[1]]);
    let film = folder.path().join("rollout.gif");
    run("rollout", &[out, "--steps", "3", "--out", film.to_str().unwrap()]);
    let metrics = std::fs::read_to_string(PathBuf::from(out).join("metrics.csv")).unwrap();
    metrics.lines().next().unwrap().to_owned()
}

#[test]
fn td3() {
    for arguments in [
        &[][..],
        &["--projection", "independent-min"],
        &["--order", "vsc", "--method", "cop-td3-oac"],
        &["--method", "cop-td3-paper", "--projection", "independent-min"],
        &["--set", "normalise=false", "--set", "networks.activation=silu"],
    ] {
        let metrics = train("td3", arguments, "150", ["180", "200"]);
        assert!(metrics.contains("critic_loss/safety"));
        let famo = ["cop-td3-paper", "cop-td3-oac"].iter().any(|method| arguments.contains(method));
        assert_eq!(metrics.contains("famo/"), famo, "{arguments:?}: {metrics}");
    }
    let plain = train("td3", &["--method", "td3", "--task", "gym/hopper"], "150", ["180", "200"]);
    assert!(plain.contains("critic_loss/reward") && !plain.contains("famo/"), "{plain}");
}

#[test]
fn redq() {
    assert!(train("redq", &[], "280", ["283", "285"]).contains("q_spread/safety"));
    train("redq", &["--oac"], "280", ["281", "282"]);
    train("redq", &["--oac", "--projection", "extremum"], "280", ["281", "282"]);
    for arguments in [&["--sac"][..], &["--sac", "--oac"], &["--sac", "--oac", "--projection", "extremum"]] {
        assert!(train("redq", arguments, "280", ["281", "282"]).contains("actor/temperature"));
    }
}

#[test]
fn sac_lagrangian() {
    for method in ["cop-cal", "cal", "cal-original", "saclag-ucb", "sac-lagrangian", "sac-pid", "cal --order rc"] {
        let arguments: Vec<&str> = ["--method"].into_iter().chain(method.split(' ')).collect();
        let metrics = train("sac_lagrangian", &arguments, "150", ["200", "240"]);
        let multiplier = ["multiplier/cost", "multiplier_effective/cost", "cost_estimate/cost", "cost_violation/cost"];
        for name in multiplier.into_iter().chain(["actor/temperature"]) {
            assert!(metrics.contains(name), "{method}: {metrics}");
        }
    }
}

#[test]
fn sac_without_a_limit() {
    let oac = ["--method", "sac", "--task", "a/hopper", "--set", "optimism.projection=extremum"];
    assert!(!train("sac_lagrangian", &oac, "150", ["180", "200"]).contains("multiplier"));
}

#[test]
fn without_an_entropy_bonus_the_policy_is_deterministic_and_rollout_knows() {
    let metrics = train("sac_lagrangian", &["--set", "entropy=none"], "150", ["180", "200"]);
    assert!(metrics.contains("multiplier/cost") && !metrics.contains("actor/entropy"), "{metrics}");
}

#[test]
fn an_example_reads_in_under_a_hundred_lines() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let examples = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    for path in examples.filter(|path| path.extension().is_some_and(|ending| ending == "rs")) {
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines < 100, "{} has {lines}", path.display());
    }
}

#[test]
fn wrong_words_are_readable_errors() {
    for (name, arguments, wanted) in [
        (
            "sac_lagrangian",
            "--task a/hopper",
            "Error: a constraint on 'a/hopper': wanted a task with a cost under a limit",
        ),
        ("redq", "--projection cholesky", "--projection: wanted --oac beside it"),
        ("td3", "--set optimism.shift=1", "--set optimism: wanted --method cop-td3-oac beside it"),
        ("redq", "--oac --set optimism=none", "wanted optimism with --oac and none without"),
        ("redq", "--oac --projection choleski", "Error: unknown projection 'choleski'; known: cholesky"),
        (
            "td3",
            "--method td3",
            "Error: --method td3: wanted a task with one objective, such as --task gym/hopper, got a/hopper",
        ),
        ("td3", "--set bach=3", "unknown field `bach`, expected one of `discount`"),
        ("custom_env", "many", "Error: the argument: wanted steps to train for, such as 20000, got many"),
    ] {
        let output = Command::new(path(name)).args(arguments.split(' ')).env("RUST_BACKTRACE", "0").output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && error.contains(wanted), "{name} {arguments}: {error}");
    }
}

#[test]
fn swap_projection() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--steps", "120", "--out", folder.path().to_str().unwrap()];
    let table = run("swap_projection", &arguments);
    assert_eq!(run("swap_projection", &arguments), table, "what is finished is not trained again");
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
