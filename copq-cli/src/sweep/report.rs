//! The page of a sweep.

use std::collections::BTreeMap;
use std::path::PathBuf;

use copq_experiments::paper::Paper;
use copq_experiments::{
    Plan, Report as Page, ReportRun, RunSettings, Standing, fingerprint, steps_done,
};

use super::file::{SweepFile, Task};
use crate::report::{Making, find};
use crate::saved;

/// Puts a sweep's runs on one page, including those that have not begun.
///
/// Example: copq sweep report experiments/quick.toml
#[derive(clap::Args)]
pub struct Report {
    #[command(flatten)]
    named: super::Named,

    #[command(flatten)]
    making: Making,

    /// Also look for runs in this folder, whatever their length. For a run that has not begun, one
    /// of the same method, settings, task and seed anywhere in it takes its place, up to the steps
    /// that the file wants.
    #[arg(long, value_name = "DIR")]
    from: Vec<PathBuf>,
}

impl Report {
    pub fn run(self) -> anyhow::Result<()> {
        let Self { named, making, from } = self;
        let sweep = SweepFile::read(&named.file)?;
        let elsewhere = runs_in(&from)?;
        let making = making.beside(sweep.paper);
        making.make(&sweep.out.join("report.html"), &sweep.title, || {
            Ok(sweep.tasks.iter().map(|task| of_task(task, &elsewhere)).collect())
        })
    }
}

/// An error for a paper's numbers and claims that match no run of the file, before anything runs.
pub fn check_paper(sweep: &SweepFile) -> anyhow::Result<()> {
    if sweep.paper == Paper::default() {
        return Ok(());
    }
    let runs = sweep.tasks.iter().map(|task| of_task(task, &BTreeMap::new()));
    Page::read(&sweep.title, &runs.collect::<Vec<_>>()).paper(sweep.paper.clone())?;
    Ok(())
}

fn of_task(task: &Task, elsewhere: &BTreeMap<String, PathBuf>) -> ReportRun {
    let mut folder = task.folder.clone();
    if Standing::of(&folder) == Standing::Waiting
        && let Some(other) = identity(&task.plan, &task.settings).and_then(|it| elsewhere.get(&it))
    {
        folder.clone_from(other);
    }
    let is_own = folder == task.folder;
    let run = ReportRun {
        label: task.arm.clone(),
        planned: Some((task.plan.clone(), task.settings.clone())),
        fingerprint: is_own.then(|| task.fingerprint.clone()),
        ..ReportRun::new(folder)
    };
    crate::report::of_task(run, &task.plan)
}

/// The runs in some folders, by their identity.
fn runs_in(folders: &[PathBuf]) -> anyhow::Result<BTreeMap<String, PathBuf>> {
    let mut runs = BTreeMap::new();
    for folder in folders {
        find(folder, &mut |run| {
            // What cannot be read is not a run of the file.
            let Ok((plan, recipe)) = saved::run(run) else { return };
            let Ok(settings) = recipe.settings() else { return };
            let Some(it) = identity(&plan, &settings) else { return };
            // Of several, the longest.
            let known = runs.entry(it).or_insert_with(|| run.to_owned());
            if steps_done(run) > steps_done(known) {
                run.clone_into(known);
            }
        })?;
    }
    Ok(runs)
}

/// What a run is, regardless of its length and cadence.
fn identity(plan: &Plan, settings: &toml::Table) -> Option<String> {
    let run = RunSettings { seed: plan.run.seed, ..RunSettings::default() };
    fingerprint(&Plan { run, critics: None, ..plan.clone() }, settings).ok()
}
