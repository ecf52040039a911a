//! The files of a finished run.

use approx::assert_abs_diff_eq;
use std::path::Path;

use copq_experiments::{
    Ending, RunConfig, RunFolder, Sheet, comparison_table, read_checkpoint, read_config,
};

use crate::events;
use crate::point_mass::{self, Settings, plan, settings};

fn finished(folder: &Path) {
    let plan = plan(1, 620);
    let folder = RunFolder::create(folder, &plan, &settings()).unwrap();
    let path = folder.path().to_owned();
    assert_eq!(
        point_mass::run(folder, &plan).silent().train().unwrap(),
        Ending::Finished { folder: path }
    );
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_run_leaves_all_its_files() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("new/run");
    finished(&folder);
    let names = names(&folder);
    let (events, others): (Vec<_>, Vec<_>) =
        names.iter().partition(|name| name.starts_with("events.out.tfevents."));
    let wanted = [
        ".lock",
        "DONE",
        "checkpoint.1.safetensors",
        "checkpoint.safetensors",
        "config.toml",
        "curve.png",
        "curve.svg",
        "evaluations.csv",
        "log.txt",
        "metrics.csv",
        "timings.csv",
    ];
    assert_eq!((events.len(), others), (1, wanted.map(String::from).iter().collect()));
    let config: RunConfig<Settings> = read_config(&folder).unwrap();
    assert_eq!((config.plan, config.settings), (plan(1, 620), settings()));
    assert!(config.made_with.rustc.starts_with("rustc 1."));
    let state = read_checkpoint(&folder).unwrap();
    assert_eq!(state.child("trainer").unwrap().get_one::<u64>("steps").unwrap(), 620);
    let curve = std::fs::read_to_string(folder.join("curve.svg")).unwrap();
    assert!(curve.contains("Dashed: the limit."), "the limit of the task's cost is drawn");
}

#[test]
fn rows_are_at_their_intervals_and_at_the_end() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("run");
    finished(&folder);
    let sheet = |name: &str| Sheet::read(&folder.join(name)).unwrap();
    let metrics = sheet("metrics.csv");
    let evaluations = sheet("evaluations.csv");
    assert_eq!(metrics.steps(), [100, 200, 300, 400, 500, 600, 620]);
    assert_eq!(sheet("timings.csv").steps(), metrics.steps());
    assert_eq!(evaluations.steps(), [0, 250, 500, 620]);
    let wanted = [
        "step",
        "train/length",
        "train/return/effort",
        "train/return/speed",
        "train/weighted_total",
        "q/effort",
    ];
    assert_eq!(metrics.columns()[..6], wanted);
    assert!(metrics.column("q/speed").unwrap()[0].is_nan(), "nothing is logged in the warm-up");
    let column = |name: &str| evaluations.column(name).unwrap();
    let total = column("return/speed/mean")[3] - 0.5 * column("return/effort/mean")[3];
    assert_abs_diff_eq!(total, column("weighted_total/mean")[3], epsilon = 1e-9);
    assert!(column("return/speed/min")[3] < column("return/speed/mean")[3]);
    assert!(column("q_start/speed")[3].is_finite());
    // Critics of 620 steps do not know yet what comes.
    let [said, came] = ["q_start/effort", "discounted/effort"].map(|name| column(name)[3]);
    assert!(came > 10.0 * said.abs(), "{said} {came}");
}

#[test]
fn tensorboard_gets_the_same_numbers() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("run");
    finished(&folder);
    let file = names(&folder).into_iter().find(|name| name.starts_with("events.")).unwrap();
    let scalars = events::scalars(&folder.join(file));
    let of = |tag: &str| -> Vec<(u64, f32)> {
        scalars
            .iter()
            .filter(|scalar| scalar.1 == tag)
            .map(|&(step, _, value)| (step, value))
            .collect()
    };
    let rows = |file: &str, column: &str| -> Vec<(u64, f32)> {
        let sheet = Sheet::read(&folder.join(file)).unwrap();
        let values = sheet.column(column).unwrap().into_iter().map(|value| value as f32);
        sheet.steps().into_iter().zip(values).filter(|(_, value)| !value.is_nan()).collect()
    };
    assert_eq!(of("q/speed"), rows("metrics.csv", "q/speed"));
    assert_eq!(of("evaluation/return/effort"), rows("evaluations.csv", "return/effort/mean"));
    assert_eq!(of("time/steps_per_second").len(), 7);
}

#[test]
fn a_run_is_not_overwritten() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("run");
    finished(&folder);
    let message = RunFolder::create(&folder, &plan(1, 620), &settings()).unwrap_err().to_string();
    assert!(
        message.contains(&format!("RunFolder::resume({folder:?}, ..)"))
            && message.contains("another --out")
    );
    std::fs::create_dir(temporary.path().join("mine")).unwrap();
    std::fs::write(temporary.path().join("mine/notes.txt"), "").unwrap();
    assert!(RunFolder::create(temporary.path().join("mine"), &plan(1, 620), &settings()).is_err());
    let open = RunFolder::resume(&folder, &plan(1, 620), &settings()).unwrap();
    let message =
        RunFolder::resume(open.path(), &plan(1, 620), &settings()).unwrap_err().to_string();
    assert!(message.contains("no other process writes to"), "{message}");
}

#[test]
fn a_run_that_has_saved_nothing_yet_has_no_checkpoint() {
    let temporary = tempfile::tempdir().unwrap();
    let folder =
        RunFolder::create(temporary.path().join("run"), &plan(1, 620), &settings()).unwrap();
    let message = read_checkpoint(folder.path()).unwrap_err().to_string();
    assert!(
        message.contains("run': wanted one with a checkpoint")
            && message.ends_with("got one without"),
        "{message}"
    );
}

#[test]
fn another_plan_or_other_settings_do_not_resume() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("run");
    finished(&folder);
    let message =
        |plan, settings| RunFolder::resume(&folder, &plan, &settings).unwrap_err().to_string();
    assert!(message(plan(1, 620), Settings { rate: 0.5 }).starts_with("settings.rate "));
    assert!(message(plan(1, 619), settings()).contains("at least the planned 620, got 619"));
    assert!(message(plan(2, 620), settings()).starts_with("plan.run.seed "));
}

#[test]
fn a_finished_run_has_a_row_in_a_comparison() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("run");
    finished(&folder);
    let runs = [copq_experiments::ReportRun::new(folder).called("pusher")];
    let table = comparison_table(&runs, None).unwrap();
    let head =
        "| label | seeds | steps | weighted total | speed | effort | mean of the whole run |\n";
    assert!(table.starts_with(head), "{table}");
    assert_eq!(table.lines().count(), 3);
}
