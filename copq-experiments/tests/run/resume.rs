//! A run that was stopped and resumed equals one that was not, byte for byte.

use std::path::{Path, PathBuf};

use copq_experiments::{Ending, Plan, Run, RunFolder, read_plan};

use crate::events;
use crate::point_mass::{self, Settings, plan, settings};

/// The files that may not depend on time.
pub const SAME: [&str; 5] =
    ["metrics.csv", "evaluations.csv", "checkpoint.safetensors", "curve.svg", "curve.png"];

/// Begins or goes on with a run.
pub fn train(folder: &Path, seed: u64, steps: u64) {
    let plan = plan(seed, steps);
    let ending = point_mass::run(open(folder, &plan), &plan).silent().train().unwrap();
    assert!(matches!(ending, Ending::Finished { .. }));
}

/// A run's folder, made or opened again.
pub fn open(folder: &Path, plan: &Plan) -> RunFolder {
    let open = if folder.exists() { RunFolder::resume } else { RunFolder::create };
    open(folder, plan, &settings()).unwrap()
}

/// Compares what two runs left.
pub fn assert_same(a: &Path, b: &Path) {
    for name in SAME {
        let read = |folder: &Path| std::fs::read(folder.join(name)).unwrap();
        assert!(read(a) == read(b), "{name} differs in {} and {}", a.display(), b.display());
    }
}

#[test]
fn two_thousand_steps_are_one_thousand_and_one_thousand() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let parts = temporary.path().join("parts");
    train(&whole, 7, 2_000);
    train(&parts, 7, 1_000);
    train(&parts, 7, 2_000);
    assert_same(&whole, &parts);
    assert!(std::fs::read_to_string(parts.join("config.toml")).unwrap().contains("steps = 2000\n"));
}

#[test]
fn ends_off_every_interval_leave_no_trace() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let parts = temporary.path().join("parts");
    train(&whole, 3, 1_234);
    for steps in [13, 477, 477, 480, 1_101, 1_234] {
        train(&parts, 3, steps);
    }
    assert_same(&whole, &parts);
}

#[test]
fn a_run_that_has_ended_is_left_as_it_is() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    train(&run, 3, 477);
    // As if its last evaluation, which is off the interval, had been the best.
    let best = run.join("policy-best.safetensors");
    copq::files::replace(&best, b"the best").unwrap();
    let file = run.join("evaluations.csv");
    let rows = std::fs::read_to_string(&file).unwrap();
    let total = rows.lines().next().unwrap().split(',').position(|n| n == "weighted_total/mean");
    let (before, last) = rows.trim_end().rsplit_once('\n').unwrap();
    let mut last: Vec<_> = last.split(',').collect();
    last[total.unwrap()] = "1000";
    let rows = format!("{before}\n{}\n", last.join(","));
    std::fs::write(&file, &rows).unwrap();
    train(&run, 3, 477);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), rows);
    assert!(best.exists() && !run.join("policy-best-before.safetensors").exists());
    let log = std::fs::read_to_string(run.join("log.txt")).unwrap();
    assert!(log.contains("nothing to do") && !log.contains("no longer among"), "{log}");
}

#[test]
fn a_run_whose_settings_were_edited_says_so() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    let edit = |from: &str, to: &str| {
        let file = run.join("config.toml");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "{text}");
        std::fs::write(file, text.replace(from, to)).unwrap();
    };
    let go_on = |plan: &Plan, rate: f32| {
        let folder = RunFolder::resume(&run, plan, &Settings { rate }).unwrap();
        point_mass::run(folder, plan).silent().train().unwrap();
        std::fs::read_to_string(run.join("log.txt")).unwrap()
    };
    train(&run, 3, 300);
    train(&run, 3, 600);
    edit("rate = 0.01\n", "rate = 0.5\n");
    let log = go_on(&plan(3, 900), 0.5);
    let told = "config.toml was edited: settings.rate was 0.01 and is 0.5 from here on";
    assert_eq!(log.matches("was edited").count(), 1, "{log}");
    assert!(log.contains(told), "{log}");
    edit("eval_episodes = 4\n", "eval_episodes = 2\n");
    let mut plan = plan(3, 1_200);
    plan.run.eval_episodes = 2;
    let told = "config.toml was edited: plan.run.eval_episodes was 4 and is 2 from here on";
    let log = go_on(&plan, 0.5);
    assert!(log.matches("was edited").count() == 2 && log.contains(told), "{log}");
}

/// The step from which on the newest events of a folder void those before.
fn first_step_of_events(folder: &Path) -> i64 {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_events = |path: &PathBuf| path.to_string_lossy().contains("events.out.tfevents.");
    events::read(&files.filter(is_events).max().unwrap())[1].step // After the version.
}

#[test]
fn tensorboard_forgets_the_rows_that_go() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    // Rows at every hundredth step, and the last one of a shorter run.
    for (steps, wanted) in [(70, 0), (477, 1), (600, 401), (700, 601)] {
        train(&path, 3, steps);
        assert_eq!(first_step_of_events(&path), wanted, "{steps}");
    }
}

#[test]
fn rows_after_the_checkpoint_and_torn_rows_are_written_again() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let crashed = temporary.path().join("crashed");
    train(&whole, 5, 900);
    train(&crashed, 5, 600);
    for (name, torn) in
        [("metrics.csv", "\n700,1,2,3,4,5,6\n800,70,"), ("evaluations.csv", "750,4,1.0")]
    {
        let path = crashed.join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text + torn).unwrap();
    }
    std::fs::write(crashed.join(".checkpoint.safetensors.part"), "half of a").unwrap();
    train(&crashed, 5, 900);
    assert_same(&whole, &crashed);
    assert!(!crashed.join(".checkpoint.safetensors.part").exists());
}

#[test]
fn a_run_without_a_checkpoint_begins_anew() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let bare = temporary.path().join("bare");
    train(&whole, 5, 600);
    train(&bare, 5, 290);
    std::fs::remove_file(bare.join("checkpoint.safetensors")).unwrap();
    // Done, it has something to lose.
    let error = RunFolder::resume(&bare, &plan(5, 600), &settings()).unwrap_err().to_string();
    assert!(error.contains("wanted the checkpoint of the finished run"), "{error}");
    std::fs::remove_file(bare.join("DONE")).unwrap();
    train(&bare, 5, 600);
    assert_same(&whole, &bare);
}

#[test]
fn a_run_that_lost_its_checkpoint_loses_nothing_more() {
    let temporary = tempfile::tempdir().unwrap();
    let bare = temporary.path().join("bare");
    train(&bare, 5, 600);
    std::fs::remove_file(bare.join("checkpoint.safetensors")).unwrap();
    let folder = RunFolder::resume(&bare, &plan(5, 900), &settings()).unwrap();
    let error = folder.load().unwrap_err().to_string();
    assert!(error.contains("RunFolder::go_back resumes from"), "{error}");
    drop(folder);
    std::fs::remove_file(bare.join("checkpoint.1.safetensors")).unwrap();
    std::fs::remove_file(bare.join("DONE")).unwrap();
    let evaluations = std::fs::read_to_string(bare.join("evaluations.csv")).unwrap();
    let plan = plan(5, 900);
    let eval_env = Box::new(point_mass::PointMass::new());
    let folder = RunFolder::resume(&bare, &plan, &settings()).unwrap();
    let error =
        Run::new(point_mass::trainer(5), Some(eval_env), folder, plan.run).unwrap_err().to_string();
    assert!(
        error.contains("wanted its checkpoint.safetensors") && error.ends_with("up to step 600"),
        "{error}"
    );
    assert_eq!(std::fs::read_to_string(bare.join("evaluations.csv")).unwrap(), evaluations);
}

#[test]
fn a_run_goes_on_with_more_threads() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    train(&path, 5, 300);
    let more = Plan { threads: 2, ..plan(5, 300) };
    let folder = RunFolder::resume(&path, &more, &settings()).unwrap();
    assert_eq!(read_plan(&path).unwrap(), plan(5, 300), "it may still not fit");
    let eval_env = Box::new(point_mass::PointMass::new());
    drop(Run::new(point_mass::trainer(5), Some(eval_env), folder, more.run).unwrap());
    assert_eq!(read_plan(&path).unwrap(), more);
    let none = Plan { threads: 0, ..more };
    let error = RunFolder::resume(&path, &none, &settings()).unwrap_err().to_string();
    assert_eq!(error, "threads: wanted 1 to 256, got 0");
}

/// Killed between a new checkpoint and the moment when the one before has its place.
#[test]
fn the_checkpoint_before_finds_its_place_after_a_kill() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let killed = temporary.path().join("killed");
    train(&whole, 5, 900);
    train(&killed, 5, 600);
    let [before, older] = [".checkpoint.before", "checkpoint.1.safetensors"];
    std::fs::rename(killed.join(older), killed.join(before)).unwrap();
    train(&killed, 5, 600);
    assert!(killed.join(older).exists() && !killed.join(before).exists());
    // Killed a moment sooner, it is the newest one's second name.
    std::fs::hard_link(killed.join("checkpoint.safetensors"), killed.join(before)).unwrap();
    let kept = std::fs::read(killed.join(older)).unwrap();
    train(&killed, 5, 600);
    assert!(std::fs::read(killed.join(older)).unwrap() == kept && !killed.join(before).exists());
    train(&killed, 5, 900);
    assert_same(&whole, &killed);
}

/// Checkpoints more often than when it began: what it has done without one is no loss.
#[test]
fn a_run_without_a_checkpoint_may_be_saved_more_often() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    train(&path, 5, 290);
    for name in ["checkpoint.safetensors", "DONE"] {
        std::fs::remove_file(path.join(name)).unwrap();
    }
    let mut plan = plan(5, 600);
    plan.run.checkpoint_every = 100;
    let ending = point_mass::run(open(&path, &plan), &plan).silent().train().unwrap();
    assert!(matches!(ending, Ending::Finished { .. }));
}
