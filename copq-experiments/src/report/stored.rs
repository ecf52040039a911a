//! A run's folder, each of its files read once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use copq::Result;

use crate::config::RunConfig;
use crate::figure::{Evaluated, Line};
use crate::folder::{read_config, read_done};
use crate::plan::Plan;
use crate::sheet::Sheet;
use crate::standing::Standing;
use crate::statistics::median;

/// Most points of a curve of training's own numbers; more cannot be told apart.
const POINTS: u64 = 200;
/// Prefixes of the columns of `metrics.csv` that the page draws.
const TRACES: [&str; 7] = [
    "clip_rate",
    "critic_loss/",
    "pessimism/",
    "correlation/",
    "multiplier/",
    "explained_variance/",
    "q_std/",
];

/// Prefix of the traces that come from evaluations.
const VALUE_ERROR: &str = "value_error/";

/// A run for a [`Report`](super::Report) or [`compare`](crate::compare): its folder, and what the
/// folder does not say.
///
/// ```
/// use copq_experiments::ReportRun;
///
/// let mut run = ReportRun::new("runs/cop-td3-a-hopper-cholesky-s0");
/// run.limits.insert("cost".to_owned(), 740.2);
/// assert_eq!(run.label, None); // what sets it apart from the others
/// ```
#[derive(Clone, Debug)]
pub struct ReportRun {
    /// The run's folder; it need not be there yet.
    pub folder: PathBuf,
    /// The method's name, if it is not named by what sets it apart.
    pub label: Option<String>,
    /// The limits of its task's costs.
    pub limits: BTreeMap<String, f64>,
    /// The weights of its task's objectives.
    pub weights: BTreeMap<String, f64>,
    /// What it should be: its plan and settings. If the run is longer, curves and tables show no
    /// more.
    pub planned: Option<(Plan, toml::Table)>,
    /// The [`fingerprint`](crate::fingerprint()) that it must have, if it is known.
    pub fingerprint: Option<String>,
}

impl ReportRun {
    /// The run in a folder.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            label: None,
            limits: BTreeMap::new(),
            weights: BTreeMap::new(),
            planned: None,
            fingerprint: None,
        }
    }

    /// The same with a name for its method, in the legend and in tables; runs with one name are
    /// seeds of one method.
    pub fn called(self, label: impl Into<String>) -> Self {
        Self { label: Some(label.into()), ..self }
    }
}

/// What is known about a run.
#[derive(Clone, Debug)]
pub(crate) struct Stored {
    pub run: ReportRun,
    pub standing: Standing,
    /// Its plan and settings: what made it, or what will.
    pub what: Option<(Plan, toml::Table)>,
    /// What made it.
    pub config: Option<RunConfig<toml::Table>>,
    pub evaluated: Option<Evaluated>,
    /// What could not be read, in words.
    pub problems: Vec<String>,
    /// Steps done, seconds that they took, and the median speed.
    pub steps: u64,
    pub seconds: f64,
    pub rate: f64,
    /// How many steps a point of a trace covers.
    pub bin: u64,
    /// Columns of `metrics.csv`, and the critics' errors at each evaluation: step and value.
    pub traces: Traces,
}

/// Columns, each with its steps and values.
type Traces = Vec<(String, Line)>;

impl Stored {
    /// Reads what is there; what cannot be read is one of its problems.
    pub(crate) fn read(run: &ReportRun) -> Self {
        let folder = &run.folder;
        let mut problems = Vec::new();
        let config: Option<RunConfig<toml::Table>> =
            read_if_there(folder, "config.toml", read_config, &mut problems);
        let evaluated =
            read_if_there(folder, "evaluations.csv", Evaluated::read_if_any, &mut problems);
        let evaluated = evaluated.flatten();
        problems.extend(evaluated.as_ref().and_then(Evaluated::damage).cloned());
        let times = read_if_there(folder, "timings.csv", read_times, &mut problems);
        let [steps, seconds, rate] = times.unwrap_or([0.0, 0.0, f64::NAN]);
        let planned = run.planned.as_ref().map(|(plan, _)| plan.run.steps);
        // If a longer run is in its place, only what is wanted of it counts.
        let end = run.planned.as_ref().map_or(u64::MAX, |(plan, _)| plan.last_step());
        let evaluated = evaluated.map(|evaluated| evaluated.until(end));
        let wanted = config.as_ref().map(|config| config.plan.run.steps);
        // The same width for all seeds of one length, however far each has come.
        let bin = (planned.or(wanted).unwrap_or(steps as u64) / POINTS).max(1);
        let traces = read_if_there(folder, "metrics.csv", |it| read_traces(it, bin), &mut problems);
        let (mut traces, damage) = traces.unwrap_or_default();
        problems.extend(damage);
        traces.extend(evaluated.iter().flat_map(Evaluated::value_errors));
        traces.iter_mut().for_each(|(_, line)| line.retain(|point| point[0] <= end as f64));
        let made = config.as_ref().map(|config| (config.plan.clone(), config.settings.clone()));
        let done = read_done(folder);
        problems.extend(missing(folder, config.as_ref(), done.is_some()));
        if done.is_some() && run.fingerprint.is_some() && done != run.fingerprint {
            problems.push("done by other settings than the sweep's file has now".to_owned());
        }
        let has_all = config.as_ref().is_some_and(|config| {
            let wanted = planned.unwrap_or(config.plan.run.steps);
            let evaluated_to = evaluated.as_ref().map_or(0, Evaluated::last_step);
            steps >= wanted as f64 && (config.plan.run.eval_every == 0 || evaluated_to >= wanted)
        });
        let is_short = wanted.zip(planned).is_some_and(|(wanted, planned)| wanted < planned);
        Self {
            run: run.clone(),
            standing: standing(folder, has_all, is_short),
            what: made.or_else(|| run.planned.clone()),
            config,
            evaluated,
            problems,
            steps: steps as u64,
            seconds,
            rate,
            bin,
            traces,
        }
    }

    /// A trace in bins that seeds share, of this width or wider.
    pub(crate) fn trace(&self, name: &str, bin: u64) -> Option<Line> {
        let (_, points) = self.traces.iter().find(|(known, _)| known == name)?;
        if bin == self.bin || name.starts_with(VALUE_ERROR) {
            return Some(points.clone());
        }
        Some(binned(points.iter().map(|&[at, value]| (at as u64, value)), bin))
    }

    /// The folder's own name.
    pub(crate) fn name(&self) -> String {
        self.run.folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The step of its last evaluation.
    pub(crate) fn end(&self) -> Option<u64> {
        self.evaluated.as_ref().map(Evaluated::last_step)
    }

    /// The steps that it should have: what is wanted now, however it began.
    pub(crate) fn steps_wanted(&self) -> Option<u64> {
        let planned = self.run.planned.as_ref().map(|(plan, _)| plan);
        planned.or(self.plan()).map(|plan| plan.run.steps)
    }

    /// Its plan.
    pub(crate) fn plan(&self) -> Option<&Plan> {
        self.what.as_ref().map(|(plan, _)| plan)
    }
}

/// The standing of a run that may have all its steps and evaluations, or fewer than are wanted now.
fn standing(folder: &Path, has_all: bool, is_short: bool) -> Standing {
    match Standing::of(folder) {
        // A run from before there was a file `DONE`.
        Standing::Stopped if has_all => Standing::Done,
        Standing::Done if is_short => Standing::Stopped,
        standing => standing,
    }
}

/// The files that a run must have left but that are not there.
fn missing(
    folder: &Path,
    config: Option<&RunConfig<toml::Table>>,
    is_done: bool,
) -> impl Iterator<Item = String> {
    let evaluates = config.is_none_or(|config| config.plan.run.eval_every > 0);
    let names = [("config.toml", true), ("metrics.csv", true), ("evaluations.csv", evaluates)];
    let lost = names.into_iter().filter(|&(name, must)| must && !folder.join(name).exists());
    let lost: Vec<_> = lost.map(|(name, _)| format!("{name} is not there")).collect();
    lost.into_iter().filter(move |_| is_done)
}

/// The content of a file, if it is there; one that cannot be read is a problem.
fn read_if_there<T>(
    folder: &Path,
    file: &str,
    read: impl Fn(&Path) -> Result<T>,
    problems: &mut Vec<String>,
) -> Option<T> {
    let is_there = folder.join(file).is_file();
    let found = is_there.then(|| read(folder))?;
    found.map_err(|error| problems.push(error.to_string())).ok()
}

/// The last step, the seconds of all steps, and the median of the speeds.
fn read_times(folder: &Path) -> Result<[f64; 3]> {
    let sheet = Sheet::read(&folder.join("timings.csv"))?;
    let seconds = sheet.column("seconds").unwrap_or_default();
    let rates = sheet.column("steps_per_second").unwrap_or_default();
    let steps = sheet.steps().last().copied().unwrap_or(0);
    Ok([steps as f64, seconds.iter().sum(), median(&rates)])
}

/// The columns that the page draws, as means over bins of steps, each at its bin's middle, and why
/// there are no more.
fn read_traces(folder: &Path, bin: u64) -> Result<(Traces, Option<String>)> {
    let file = folder.join("metrics.csv");
    let sheet = Sheet::read(&file)?;
    let damage = sheet.damage(&file).map(|error| error.to_string());
    let steps = sheet.steps();
    let names = sheet.columns().iter();
    let names = names.filter(|name| TRACES.iter().any(|trace| name.starts_with(trace)));
    let trace = |name: &String| {
        // A row covers the steps before it.
        let rows = steps.iter().map(|step| step.saturating_sub(1)).zip(sheet.column(name)?);
        Some((name.clone(), binned(rows, bin)))
    };
    Ok((names.filter_map(trace).collect(), damage))
}

/// Means over bins of `bin` steps, each at its bin's middle.
fn binned(points: impl Iterator<Item = (u64, f64)>, bin: u64) -> Line {
    let mut bins: BTreeMap<u64, (f64, f64)> = BTreeMap::new();
    for (step, value) in points.filter(|(_, value)| value.is_finite()) {
        let (sum, count) = bins.entry(step / bin).or_default();
        *sum += value;
        *count += 1.0;
    }
    let middle =
        |(index, (sum, count)): (u64, (f64, f64))| [(index as f64 + 0.5) * bin as f64, sum / count];
    bins.into_iter().map(middle).collect()
}
