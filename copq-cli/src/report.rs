//! `copq report`: many runs on one page.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use copq::files;
use copq_envs::{Options, task_with};
use copq_experiments::{Plan, Report as Page, ReportRun, Stop, read_plan};

use crate::options::{number_of, positive, say};
use crate::rollout::film;

/// How deep runs are looked for.
const DEPTH: usize = 4;

/// Puts many runs on one page: what was run, curves, tables, settings, failures.
///
/// The page is one file for any browser, without a server or a script from elsewhere. Runs of one
/// task are drawn together; a method is called by what sets it apart from the others.
///
/// Example: copq report runs --out report.html
#[derive(clap::Args)]
pub struct Report {
    #[command(flatten)]
    making: Making,

    /// A run's folder, or one with runs anywhere in it; LABEL=DIR gives its method a name.
    #[arg(required = true, value_name = "[LABEL=]DIR")]
    runs: Vec<String>,
}

/// How a page is made, whatever is on it.
#[derive(clap::Args)]
pub struct Making {
    /// The page to write. [default: report.html; of a sweep in the folder of its runs]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// The page's title. [default: the folders' or the sweep's name]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,

    /// Writes the page again every so many seconds while runs go on; the page loads itself again,
    /// too.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    every: Option<u64>,

    /// Also writes the tables as Markdown, LaTeX and CSV and the figures as SVG and PNG into this
    /// folder, for a paper.
    #[arg(long, value_name = "DIR")]
    parts: Option<PathBuf>,

    /// A task's score that counts as 1 where tasks are taken together, such as a/hopper=3042; may
    /// be given several times.
    #[arg(long, value_name = "TASK=SCORE", value_parser = number_of)]
    reference: Vec<(String, f64)>,

    /// Films a policy of every method on each task first (rollout.gif in the run's folder), and
    /// shows the films.
    #[arg(long)]
    rollouts: bool,
}

impl Report {
    pub fn run(self) -> anyhow::Result<()> {
        let title = self.runs.iter().map(|run| named(run)).collect::<Vec<_>>().join(", ");
        let Self { making, runs } = self;
        making.make(Path::new("report.html"), &title, || {
            let mut all = Vec::new();
            for text in &runs {
                let before = all.len();
                let (label, folder) = labelled(text);
                find(Path::new(folder), DEPTH, &mut |folder| {
                    all.push(ReportRun { label: label.clone(), ..of_folder(folder) });
                })?;
                ensure!(all.len() > before, "'{folder}': wanted runs in it, got none");
            }
            Ok(all)
        })
    }
}

/// LABEL=DIR, or DIR alone, if there is one of that name.
fn labelled(text: &str) -> (Option<String>, &str) {
    match text.split_once('=') {
        Some((label, folder)) if !Path::new(text).exists() => (Some(label.to_owned()), folder),
        _ => (None, text),
    }
}

/// Every run's folder in a folder, in the order of their names.
pub fn find(folder: &Path, depth: usize, found: &mut impl FnMut(&Path)) -> anyhow::Result<()> {
    if ["config.toml", "evaluations.csv"].iter().any(|name| folder.join(name).is_file()) {
        found(folder);
        return Ok(());
    }
    let entries = std::fs::read_dir(folder).map_err(files::failed("reading", folder))?;
    let mut folders: Vec<PathBuf> =
        entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    folders.iter().filter(|_| depth > 0).try_for_each(|folder| find(folder, depth - 1, found))
}

/// What a folder is called, `.` too.
fn named(text: &str) -> String {
    let path = std::path::absolute(text).unwrap_or_default();
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    if text.starts_with('.') { name.unwrap_or_else(|| text.to_owned()) } else { text.to_owned() }
}

fn of_folder(folder: &Path) -> ReportRun {
    let run = ReportRun::new(folder);
    match read_plan(folder) {
        Ok(plan) => of_task(run, &plan),
        Err(_) => run,
    }
}

/// A run with what is known of its plan's task: the limits of its costs, the plan's own or else the
/// task's, and its weights.
pub fn of_task(mut run: ReportRun, plan: &Plan) -> ReportRun {
    let options = plan.preset.parse().map(|preset| Options { preset, ..Options::default() });
    if let Ok(task) = options.and_then(|options| task_with(&plan.task, &options)) {
        for objective in task.objectives {
            run.limits.extend(objective.limit.map(|limit| (objective.name.clone(), limit)));
            run.weights.insert(objective.name, f64::from(objective.weight));
        }
    }
    run.limits.extend(plan.limits.clone());
    run
}

impl Making {
    /// With the scores of a sweep's file, under those of the command line.
    pub fn references_of(mut self, scores: &BTreeMap<String, f64>) -> Self {
        self.reference.extend(scores.iter().map(|(task, &score)| (task.clone(), score)));
        self
    }

    /// Makes the page of the runs that `runs` finds, again and again if that is wanted.
    pub fn make(
        &self,
        usual: &Path,
        title: &str,
        runs: impl Fn() -> anyhow::Result<Vec<ReportRun>>,
    ) -> anyhow::Result<()> {
        let out = self.out.as_deref().unwrap_or(usual);
        let title = self.title.as_deref().unwrap_or(title);
        if self.rollouts {
            film_one_a_method(&runs()?)?;
        }
        let every = self.every.map(Duration::from_secs);
        let stop = every.map(|_| Stop::catch()).transpose()?;
        loop {
            let page = Page::read(title, &runs()?).references(self.reference.clone());
            let is_last = stop.as_ref().is_none_or(|stop| stop.is_asked() || !page.is_going_on());
            let again = every.filter(|_| !is_last);
            files::replace(out, page.page(again)?.as_bytes())?;
            if let Some(folder) = &self.parts {
                page.write_parts(folder)?;
            }
            let summary = page.summary();
            say(&format!("{}: {summary}\n", out.display())).unwrap_or_default();
            let Some(pause) = again else { return Ok(()) };
            let began = Instant::now();
            while began.elapsed() < pause && !stop.as_ref().is_some_and(Stop::is_asked) {
                sleep(Duration::from_millis(100));
            }
        }
    }
}

/// Films the first seed of every method on each task that has a policy and no film yet.
fn film_one_a_method(runs: &[ReportRun]) -> anyhow::Result<()> {
    let mut filmed = Vec::new();
    for run in runs {
        let folder = &run.folder;
        let Ok(mut plan) = read_plan(folder) else { continue };
        plan.run.seed = 0;
        let what = (run.label.clone(), plan);
        if !folder.join("checkpoint.safetensors").is_file() || filmed.contains(&what) {
            continue;
        }
        filmed.push(what);
        if !folder.join("rollout.gif").is_file() {
            film(folder).with_context(|| format!("filming '{}'", folder.display()))?;
        }
    }
    Ok(())
}
