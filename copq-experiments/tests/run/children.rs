//! Runs in processes of their own, which signals stop at any moment.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use copq::Rng;
use copq_experiments::{Plan, RunFolder, Sheet};

use crate::point_mass::{self, plan, settings};
use crate::resume::{assert_same, open};

const FOLDER: &str = "COPQ_TEST_FOLDER";
const STEPS: &str = "COPQ_TEST_STEPS";
/// The child does something else when its run is done.
const AFTER: &str = "COPQ_TEST_AFTER";

/// Not a test by itself: what the child process runs, begun by [`spawn`].
#[test]
fn child() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let plan = busy(std::env::var(STEPS).unwrap().parse().unwrap());
    let folder = open(Path::new(&folder), &plan);
    let ending = point_mass::run(folder, &plan).train().unwrap();
    println!("{ending}");
    if std::env::var_os(AFTER).is_some() {
        std::fs::write(folder_of_child().join("trained"), "").unwrap();
        std::thread::sleep(Duration::from_secs(60));
    }
}

fn folder_of_child() -> std::path::PathBuf {
    std::env::var_os(FOLDER).unwrap().into()
}

/// A run that does little else than to save, so that it is most likely killed there.
fn busy(steps: u64) -> Plan {
    let mut plan = plan(2, steps);
    (plan.run.log_every, plan.run.eval_every, plan.run.checkpoint_every) = (10, 70, 1);
    plan
}

/// This test program again, as a run in `folder`.
fn spawn(folder: &Path, steps: u64) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "children::child", "--nocapture", "--test-threads=1"])
        .env(FOLDER, folder)
        .env(STEPS, steps.to_string())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn wait_until(what: impl Fn() -> bool) {
    let began = Instant::now();
    while !what() {
        assert!(began.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[cfg(unix)]
fn stop_with(signals: &[&str]) {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("run");
    let child = spawn(&folder, 1_000_000_000);
    let metrics = folder.join("metrics.csv");
    wait_until(|| Sheet::read(&metrics).is_ok_and(|sheet| sheet.steps().len() > 3));
    for signal in signals {
        let id = child.id().to_string();
        assert!(Command::new("kill").args([signal, &*id]).status().unwrap().success());
    }
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}");
    assert!(
        text.contains("stopped and saved at step ")
            && text.contains("go on with RunFolder::resume("),
        "{text}"
    );

    let plan = copq_experiments::read_plan(&folder).unwrap();
    let resumed = RunFolder::resume(&folder, &plan, &settings()).unwrap();
    let steps = point_mass::run(resumed, &plan).trainer_mut().steps();
    assert!(
        steps > 30 && text.replace(',', "").contains(&format!("at step {steps};")),
        "{steps} steps: {text}"
    );
}

#[test]
#[cfg(unix)]
fn sigterm_saves_and_ends_well() {
    stop_with(&["-TERM"]);
}

#[test]
#[cfg(unix)]
fn sigint_saves_and_ends_well() {
    stop_with(&["-INT"]);
}

/// A terminal's Ctrl-C goes to all, and then a pool tells its runs to stop: both are seen at once.
#[test]
#[cfg(unix)]
fn sigint_beside_sigterm_saves_and_ends_well() {
    stop_with(&["-STOP", "-INT", "-TERM", "-CONT"]);
}

#[test]
#[cfg(unix)]
fn after_a_run_signals_do_what_they_did_before() {
    use std::os::unix::process::ExitStatusExt;
    for (signal, number) in [("-INT", 2), ("-TERM", 15), ("-HUP", 1), ("-USR1", 10)] {
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path().join("run");
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "children::child", "--nocapture", "--test-threads=1"])
            .envs([(AFTER, "yes"), (STEPS, "20")])
            .env(FOLDER, &folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        wait_until(|| folder.join("trained").exists());
        let id = child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().signal(), Some(number), "{signal}");
    }
}

#[test]
fn a_run_killed_again_and_again_ends_as_if_it_had_not_been() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let killed = temporary.path().join("killed");
    assert!(spawn(&whole, 200).wait_with_output().unwrap().status.success());
    let mut moments = Rng::with_stream(11, 0);
    for _ in 0..12 {
        let mut child = spawn(&killed, 200);
        std::thread::sleep(Duration::from_micros(moments.below(400_000) as u64));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let output = spawn(&killed, 200).wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_same(&whole, &killed);
}
