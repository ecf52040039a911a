//! `copq report`: many runs on one page.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::ensure;
use copq::{files, read_weights};
use copq_envs::{Options, task_with};
use copq_experiments::paper::Paper;
use copq_experiments::{Plan, Report as Page, ReportRun, Stop, read_config, read_plan};

use crate::options::{note, number_of, positive, say};
use crate::rollout::film;
use crate::saved;

/// Looks in a row at which nothing has changed, after which no run is thought to continue.
const LOOKS: usize = 3;

/// Puts many runs on one page: what was run, curves, tables, settings, failures.
///
/// The page is one file for any browser, without a server or scripts from elsewhere. Runs of the
/// same task are drawn together. A method is named by what sets it apart from the others.
///
/// Example: copq report runs --out report.html
#[derive(clap::Args)]
pub struct Report {
    #[command(flatten)]
    making: Making,

    /// Folder of a run, or one with runs anywhere in it; LABEL=DIR gives its method a name.
    #[arg(required = true, value_name = "[LABEL=]DIR")]
    runs: Vec<String>,
}

/// How a page is made, whatever is on it.
#[derive(clap::Args)]
pub struct Making {
    /// Page to write. [default: report.html; for a sweep, in the folder of its runs]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Title of the page. [default: the folders' or the sweep's name]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,

    /// Rewrite the page every SECONDS while runs continue; the page also reloads itself.
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    every: Option<u64>,

    /// Also write the tables (Markdown, LaTeX and CSV) and the figures (SVG and PNG) into this
    /// folder, for a paper.
    #[arg(long, value_name = "DIR")]
    parts: Option<PathBuf>,

    /// Score of a task that counts as 1 where tasks are taken together, such as a/hopper=3042; may
    /// be given several times.
    #[arg(long, value_name = "TASK=SCORE", value_parser = number_of)]
    reference: Vec<(String, f64)>,

    #[arg(skip)]
    paper: Paper,

    /// First film one policy of every method on each task (rollout.gif in the run's folder) unless
    /// its film is up to date, and show the films. With --every, also when all runs are done.
    #[arg(long)]
    rollouts: bool,
}

impl Report {
    pub fn run(self) -> anyhow::Result<()> {
        let title = self.runs.iter().map(|run| named(run)).collect::<Vec<_>>().join(", ");
        let Self { making, runs } = self;
        making.make(Path::new("report.html"), &title, || {
            let mut all = Vec::new();
            let mut known = BTreeSet::new();
            for text in &runs {
                let (label, folder) = labelled(text)?;
                let mut is_empty = true;
                find(Path::new(folder), &mut |folder| {
                    is_empty = false;
                    // However it is reached, a run is one run.
                    if known.insert(folder.canonicalize().unwrap_or_else(|_| folder.to_owned())) {
                        all.push(ReportRun { label: label.clone(), ..of_folder(folder) });
                    } else if let Some(label) = &label {
                        let shown = folder.display();
                        note(&format!("{shown} is already there, so not again as {label}"));
                    }
                })?;
                ensure!(!is_empty, "'{folder}': wanted runs in it, got none");
            }
            Ok(all)
        })
    }
}

/// LABEL=DIR, or DIR alone if there is a folder of that whole name.
fn labelled(text: &str) -> anyhow::Result<(Option<String>, &str)> {
    let (label, folder) = match text.split_once('=') {
        Some((label, folder)) if !Path::new(text).exists() => (Some(label.to_owned()), folder),
        _ => (None, text),
    };
    ensure!(label.as_deref() != Some(""), "'{text}': wanted a name before the =, got none");
    ensure!(
        !Path::new(folder).is_file(),
        "'{folder}': wanted a folder, got a file (for a sweep's file, use copq sweep report)"
    );
    Ok((label, folder))
}

/// Every run's folder in a folder, in the order of their names, links last.
pub fn find(folder: &Path, found: &mut impl FnMut(&Path)) -> anyhow::Result<()> {
    find_new(folder, &mut BTreeSet::new(), found)
}

/// The same, except for folders already looked into: links may lead round in circles.
fn find_new(
    folder: &Path,
    seen: &mut BTreeSet<PathBuf>,
    found: &mut impl FnMut(&Path),
) -> anyhow::Result<()> {
    if !seen.insert(folder.canonicalize().map_err(files::failed("reading", folder))?) {
        return Ok(());
    }
    if ["config.toml", "evaluations.csv"].iter().any(|name| folder.join(name).is_file()) {
        found(folder);
        return Ok(());
    }
    let entries = std::fs::read_dir(folder).map_err(files::failed("reading", folder))?.flatten();
    let mut folders: Vec<PathBuf> =
        entries.map(|entry| entry.path()).filter(|path| may_hold_runs(path)).collect();
    folders.sort_by_cached_key(|path| (path.is_symlink(), path.clone()));
    for folder in &folders {
        // A folder that cannot be read must not hide the others.
        find_new(folder, seen, found)
            .unwrap_or_else(|error| note(&format!("not looked into: {error:#}")));
    }
    Ok(())
}

/// Whether to look into a folder: not what is hidden, and no cache (cargo's target is one).
fn may_hold_runs(path: &Path) -> bool {
    let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    path.is_dir() && !is_hidden && !path.join("CACHEDIR.TAG").exists()
}

/// A folder's name, also that of `.`.
fn named(text: &str) -> String {
    let path = std::path::absolute(text).unwrap_or_default();
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    if text.starts_with('.') { name.unwrap_or_else(|| text.to_owned()) } else { text.to_owned() }
}

/// A run with what is known of its task, if its folder says which.
pub fn of_folder(folder: &Path) -> ReportRun {
    let run = ReportRun::new(folder);
    match read_plan(folder) {
        Ok(plan) => of_task(run, &plan),
        Err(_) => run,
    }
}

/// A run with what is known of its plan's task: the limits of its costs, the plan's own or else the
/// task's, and its weights.
pub fn of_task(mut run: ReportRun, plan: &Plan) -> ReportRun {
    let mut names = Vec::new();
    let options = plan.preset.parse().map(|preset| Options { preset, ..Options::default() });
    if let Ok(task) = options.and_then(|options| task_with(&plan.task, &options)) {
        for objective in task.objectives {
            run.limits.extend(objective.limit.map(|limit| (objective.name.clone(), limit)));
            run.weights.insert(objective.name.clone(), f64::from(objective.weight));
            names.push(objective.name);
        }
    }
    // The objectives of a Python task are not known, and these would be taken for all of them.
    if let Some(weights) = plan.weights.as_ref().filter(|_| !names.is_empty()) {
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        let own = read_weights(weights, &known).unwrap_or_default().into_iter();
        run.weights.extend(own.map(|(i, weight)| (names[i].clone(), f64::from(weight))));
    }
    run.limits.extend(plan.limits.clone());
    for cost in plan.limits.keys() {
        // A multiplier weighs it.
        run.weights.entry(cost.clone()).or_insert(0.0);
    }
    run
}

impl Making {
    /// Adds what a sweep's file says about a paper; the command line's scores win.
    pub fn beside(self, paper: Paper) -> Self {
        Self { paper, ..self }
    }

    /// Makes the page of the runs that `runs` finds, again and again if that is wanted.
    pub fn make(
        &self,
        usual: &Path,
        title: &str,
        runs: impl Fn() -> anyhow::Result<Vec<ReportRun>>,
    ) -> anyhow::Result<()> {
        let out = self.out.as_deref().unwrap_or(usual);
        let is_page = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("html"));
        ensure!(is_page, "--out {}: wanted a name that ends in .html", out.display());
        if let Some(folder) = out.parent() {
            std::fs::create_dir_all(folder).map_err(files::failed("making", folder))?;
        }
        let title = self.title.as_deref().unwrap_or(title);
        let every = self.every.map(Duration::from_secs);
        let Some(every) = every else {
            let (_, summary) = self.write(out, title, &self.filmed(runs()?, true), None)?;
            return Ok(say(&format!("{}: {summary}\n", out.display()))?);
        };
        let stop = Stop::catch()?;
        let mut looks = 0;
        let mut before = String::new();
        loop {
            // Between two runs, or while a cluster restarts one, none is in progress for a moment.
            let again = (looks < LOOKS && !stop.is_asked()).then_some(every);
            let is_first_or_last = before.is_empty() || looks == LOOKS;
            let runs = runs().map(|runs| self.filmed(runs, is_first_or_last));
            match runs.and_then(|runs| self.write(out, title, &runs, again)) {
                Ok((is_going_on, summary)) => {
                    let is_news = summary != before || again.is_none();
                    looks = if is_going_on || summary != before { 0 } else { looks + 1 };
                    if is_news {
                        say(&format!("{}: {summary}\n", out.display())).unwrap_or_default();
                    }
                    before = summary;
                }
                // A folder that vanishes while it is read is no reason to stop looking.
                Err(error) if again.is_some() => note(&format!("{error:#}")),
                Err(error) => return Err(error),
            }
            if again.is_none() {
                return Ok(());
            }
            let began = Instant::now();
            while began.elapsed() < every && !stop.is_asked() {
                sleep(Duration::from_millis(100));
            }
        }
    }

    /// Runs whose policies have been filmed, if that is wanted now.
    fn filmed(&self, runs: Vec<ReportRun>, now: bool) -> Vec<ReportRun> {
        if self.rollouts && now {
            film_one_a_method(&runs);
        }
        runs
    }

    /// Writes a page; returns whether any run on it continues, and a summary.
    fn write(
        &self,
        out: &Path,
        title: &str,
        runs: &[ReportRun],
        again: Option<Duration>,
    ) -> anyhow::Result<(bool, String)> {
        let mut paper = self.paper.clone();
        paper.reference.extend(self.reference.clone());
        let page = Page::read(title, runs).paper(paper)?;
        let text = page.page(again)?;
        files::replace_shared(out, |part| {
            std::fs::write(part, &text).map_err(files::failed("writing", part))
        })?;
        if let Some(folder) = &self.parts {
            page.write_parts(folder)?;
        }
        Ok((page.is_going_on(), page.summary()))
    }
}

/// Films the first seed of every method on each task that has a policy, unless its film is as new.
fn film_one_a_method(runs: &[ReportRun]) {
    let mut filmed = Vec::new();
    for run in runs {
        let folder = &run.folder;
        let Ok(config) = read_config::<toml::Table>(folder) else { continue };
        let mut plan = config.plan;
        plan.run.seed = 0;
        let what = (run.label.clone(), plan, config.settings);
        let policies = ["checkpoint.safetensors", "policy.safetensors"];
        let has_one = policies.iter().any(|name| folder.join(name).is_file());
        if !has_one || filmed.contains(&what) {
            continue;
        }
        filmed.push(what);
        if !saved::is_filmed(folder)
            && let Err(error) = film(folder)
        {
            note(&format!("no film of '{}': {error:#}", folder.display()));
        }
    }
}
