//! A sweep's file as a list of runs, each checked as `copq train` would.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Parser;
use copq_experiments::paper::Paper;
use copq_experiments::{Plan, fingerprint, quoted, read_config, read_done, read_plan};

use super::raw::{Combination, Options, REPEATED, Raw, SUBMITTED};
use super::report::check_paper;
use crate::saved;
use crate::train::{Prepared, Train, short_name};
use crate::training::try_out;

/// The longest folder name that every file system accepts, with room for an extension.
const LONGEST: usize = 240;
/// A sweep's file, read and checked.
pub struct SweepFile {
    /// The folder of all runs.
    pub out: PathBuf,
    pub title: String,
    /// What it says about a paper.
    pub paper: Paper,
    pub tasks: Vec<Task>,
}

/// One run.
pub struct Task {
    pub folder: PathBuf,
    /// The name of its arm, if it has one.
    pub arm: Option<String>,
    pub plan: Plan,
    /// Its method's settings.
    pub settings: toml::Table,
    /// Its [`copq_experiments::fingerprint`].
    pub fingerprint: String,
    /// The fingerprint when it was submitted, if it was.
    pub submitted: Option<String>,
    /// What the file says about it.
    options: Options,
    arguments: Vec<String>,
}

// `copq train` alone, so that a task's options are parsed as its options.
#[derive(Parser)]
#[command(disable_help_flag = true)]
struct Line {
    #[command(flatten)]
    train: Train,
}

impl Task {
    /// The command as a user would type it.
    pub fn command(&self) -> String {
        let words = self.arguments.iter().map(|argument| quoted(argument));
        let folder = quoted(&self.folder.to_string_lossy());
        format!("copq train {} --out {folder}", words.collect::<Vec<_>>().join(" "))
    }

    /// What it would train; an error for options that do not fit together.
    pub fn prepare(&self) -> anyhow::Result<Prepared> {
        Ok(Prepared { plan: self.plan.clone(), ..prepare(&self.arguments)? })
    }

    /// Whether nothing is left to do.
    pub fn is_done(&self) -> bool {
        read_done(&self.folder).is_some_and(|fingerprint| fingerprint == self.fingerprint)
    }

    /// Why the run that has begun cannot continue to the file's steps, if its step size decays over
    /// its own steps.
    pub fn why_only_anew(&self) -> Option<String> {
        let begun = read_config::<toml::Table>(&self.folder).ok()?;
        let over = |settings: &toml::Table| settings.get("anneal_steps")?.as_integer();
        let (then, now) = (over(&begun.settings)?, over(&self.settings)?);
        let folder = quoted(&self.folder.to_string_lossy());
        (then < now).then(|| {
            format!(
                "its step size falls over {then} steps, the file's over {now}, which is another \
                 run: give it another folder (out, or the name of an [[arm]]); outside the sweep, \
                 copq resume {folder} --steps N continues with the last, small step size"
            )
        })
    }

    fn new(combination: &Combination, out: &Path, file: &str) -> anyhow::Result<Self> {
        let arguments = arguments(&combination.options).with_context(|| format!("'{file}'"))?;
        let mut prepared = prepare(&arguments)
            .with_context(|| format!("'{file}', copq train {}", arguments.join(" ")))?;
        let arm = combination.name.as_ref().map_or(String::new(), |name| format!("{name}-"));
        let mut name = format!("{arm}{}", prepared.name);
        if name.len() > LONGEST {
            name = arm + &short_name(&prepared.name);
        }
        ensure!(
            name.len() <= LONGEST,
            "'{file}': wanted a folder's name of at most {LONGEST} letters (name an arm), got {name}"
        );
        let settings = prepared.recipe.settings()?;
        let folder = out.join(name);
        prepared.plan.init_checksum = init_checksum(&prepared.plan, &folder);
        let submitted = combination.submitted.clone();
        // A run that has begun has its own copy of the policy.
        if let (Some(_), Ok(begun)) = (&submitted, read_plan(&folder)) {
            prepared.plan.init_checksum = begun.init_checksum;
        }
        Ok(Self {
            folder,
            arm: combination.name.clone(),
            fingerprint: fingerprint(&prepared.plan, &settings)?,
            submitted,
            settings,
            plan: prepared.plan,
            options: combination.options.clone(),
            arguments,
        })
    }
}

/// The checksum of the policy that a run begins with. A run that began before checksums were
/// written has none (and, off-policy, acted at random first: `set = "warm_up=uniform"`). If the
/// policy is gone, the checksum that the run has written is used.
fn init_checksum(plan: &Plan, folder: &Path) -> Option<String> {
    let from = plan.init_from.as_deref()?;
    let now = saved::policy_file(from).and_then(|file| saved::checksum(&file)).ok();
    match read_plan(folder) {
        Ok(begun) => begun.init_checksum.map(|then| now.unwrap_or(then)),
        Err(_) => now,
    }
}

fn prepare(arguments: &[String]) -> anyhow::Result<Prepared> {
    let words = std::iter::once("copq train").chain(arguments.iter().map(String::as_str));
    let line = Line::try_parse_from(words).map_err(|error| {
        let text = error.to_string();
        // Without clap's advice about the command line's help.
        let ends = ["\nUsage:", "\nFor more", "\n  tip: to pass"];
        let said =
            ends.iter().fold(text.as_str(), |said, end| said.split(end).next().unwrap_or(said));
        let said = said.trim_start_matches("error: ").trim();
        let is_unknown = error.kind() == clap::error::ErrorKind::UnknownArgument;
        let advice =
            if is_unknown { "; a method's setting goes into set = [\"KEY=VALUE\"]" } else { "" };
        anyhow::anyhow!("{said}{advice}")
    })?;
    line.train.prepare()
}

impl SweepFile {
    /// Reads all runs and checks each.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        Self::read_within(path, None, &mut Vec::new())
    }

    /// The same for a file that others have named, in the first one's folder.
    fn read_within(
        path: &Path,
        out: Option<&Path>,
        others: &mut Vec<PathBuf>,
    ) -> anyhow::Result<Self> {
        let shown = path.display().to_string();
        let this = path.canonicalize().with_context(|| format!("reading '{shown}'"))?;
        ensure!(!others.contains(&this), "'{shown}': wanted files that do not name each other");
        others.push(this);
        let (raw, own) = Raw::read(path)?;
        let out = out.map_or(own, Path::to_owned);
        let mut known = BTreeMap::new();
        let mut tasks = Vec::new();
        for combination in raw.combinations().with_context(|| format!("'{shown}'"))? {
            let task = Task::new(&combination, &out, &shown)?;
            let before = known.insert(task.folder.clone(), task.fingerprint.clone());
            ensure!(
                before.is_none(),
                "'{shown}': wanted each run once, got {} twice (two combinations differ in nothing \
                 that a folder is named by; give each a name as an [[arm]])",
                task.folder.display()
            );
            tasks.push(task);
        }
        let mut paper = raw.paper();
        for file in &raw.files {
            let file = path.parent().unwrap_or(Path::new("")).join(file);
            let other = Self::read_within(&file, Some(&out), others)
                .with_context(|| format!("'{shown}' has files, one of them {}", file.display()))?;
            paper = paper.and(other.paper);
            for task in other.tasks {
                match known.insert(task.folder.clone(), task.fingerprint.clone()) {
                    None => tasks.push(task),
                    Some(before) => ensure!(
                        before == task.fingerprint,
                        "'{shown}': wanted one run for each name, got two for {}, one of them in {}",
                        task.folder.display(),
                        file.display()
                    ),
                }
            }
        }
        others.pop();
        ensure!(
            !tasks.is_empty(),
            "'{shown}': wanted one run at least (a [grid] of lists), got none"
        );
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let title = raw.title.unwrap_or(stem);
        Ok(Self { out, title, paper, tasks })
    }

    /// All runs, for whoever begins them. An error names the first run that could not begin because
    /// its environment or its method cannot be made; runs that differ only in seed are tried once.
    pub fn read_to_begin(path: &Path) -> anyhow::Result<Self> {
        let sweep = Self::read(path)?;
        check_paper(&sweep).with_context(|| format!("'{}'", path.display()))?;
        let mut tried = BTreeSet::new();
        for task in &sweep.tasks {
            let mut plan = task.plan.clone();
            plan.run.seed = 0;
            if tried.insert(fingerprint(&plan, &task.settings)?) {
                let prepared = task.prepare()?;
                try_out(&prepared)
                    .with_context(|| format!("'{}', {}", path.display(), task.command()))?;
            }
        }
        Ok(sweep)
    }

    /// The numbers of the runs that are not done.
    pub fn undone(&self) -> Vec<usize> {
        (0..self.tasks.len()).filter(|&number| !self.tasks[number].is_done()).collect()
    }

    /// One of its runs only, for a process that is one of thousands; or the one with the expected
    /// fingerprint, wherever it is in a file that has changed since.
    pub fn read_task(path: &Path, number: usize, expect: Option<&str>) -> anyhow::Result<Task> {
        let task = Self::read_numbered(path, number);
        let Some(expected) = expect else { return task };
        if task.as_ref().is_ok_and(|task| task.fingerprint == expected) {
            return task;
        }
        let other = Self::read(path)?.tasks.into_iter().find(|task| task.fingerprint == expected);
        other.with_context(|| {
            format!(
                "'{}', or the policy that its run begins with, has changed since this sweep was \
                 begun; start it again",
                path.display()
            )
        })
    }

    fn read_numbered(path: &Path, number: usize) -> anyhow::Result<Task> {
        let shown = path.display().to_string();
        let (raw, out) = Raw::read(path)?;
        if !raw.files.is_empty() {
            let mut tasks = Self::read(path)?.tasks;
            ensure!(number < tasks.len(), "{}", no_task(number, tasks.len(), &shown));
            return Ok(tasks.swap_remove(number));
        }
        let all = raw.combinations().with_context(|| format!("'{shown}'"))?;
        let combination = all.get(number).with_context(|| no_task(number, all.len(), &shown))?;
        Task::new(combination, &out, &shown)
    }

    /// A file of the same runs, one by one in the same order and in the folder `out`, whatever
    /// becomes of this one.
    pub fn frozen(&self, out: &Path) -> anyhow::Result<String> {
        let out = out.to_str().context("the folder's name: wanted letters, got other bytes")?;
        let include = self.tasks.iter().map(|task| {
            let mut options = toml::Table::from_iter(task.options.clone());
            options.extend(task.arm.iter().map(|arm| ("name".to_owned(), arm.clone().into())));
            options.insert(SUBMITTED.to_owned(), task.fingerprint.clone().into());
            toml::Value::Table(options)
        });
        let mut table = toml::Table::try_from(&self.paper)?;
        table.extend([
            ("out".to_owned(), out.into()),
            ("title".to_owned(), self.title.clone().into()),
            ("include".to_owned(), include.collect::<Vec<_>>().into()),
        ]);
        Ok(toml::to_string(&table)?)
    }
}

fn no_task(number: usize, count: usize, file: &str) -> String {
    format!("--task {number}: wanted one of the {count} runs of '{file}', from 0")
}

fn arguments(options: &Options) -> anyhow::Result<Vec<String>> {
    let mut arguments = Vec::new();
    for (name, value) in options {
        ensure!(name != "out", "out: wanted it for the whole sweep, got it for a run");
        ensure!(name != "like", "like: wanted options one by one, for a sweep names its folders");
        match (name.as_str(), value) {
            ("method", value) => arguments.insert(0, plain(name, value)?),
            (_, toml::Value::Array(values)) => {
                ensure!(
                    REPEATED.contains(&name.as_str()) || name == "objectives",
                    "{name}: wanted one value for a run, got a list, whose place is [grid]"
                );
                for value in values {
                    arguments.extend([format!("--{name}"), plain(name, value)?]);
                }
            }
            (_, value) => arguments.extend([format!("--{name}"), plain(name, value)?]),
        }
    }
    Ok(arguments)
}

fn plain(name: &str, value: &toml::Value) -> anyhow::Result<String> {
    match value {
        toml::Value::String(text) => Ok(text.clone()),
        toml::Value::Integer(number) => Ok(number.to_string()),
        toml::Value::Float(number) => Ok(number.to_string()),
        other => bail!("{name}: wanted a text or a number, got {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of runs with these seeds.
    fn write(path: &Path, seeds: &str) {
        std::fs::write(path, format!("[all]\nsteps = 10\n[grid]\nseed = [{seeds}]\n")).unwrap();
    }

    #[test]
    fn a_run_is_found_wherever_the_file_has_it_now() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file.toml");
        write(&file, "7");
        let run = &SweepFile::read(&file).unwrap().tasks[0];
        let found = || SweepFile::read_task(&file, 0, Some(&run.fingerprint));
        for seeds in ["7", "3, 7", "3, 4, 7, 8"] {
            write(&file, seeds);
            assert_eq!(found().unwrap().folder, run.folder, "{seeds}");
        }
        write(&file, "3");
        let error = found().err().unwrap().to_string();
        assert!(error.contains("has changed since this sweep was begun"), "{error}");
    }

    #[test]
    fn what_is_submitted_knows_what_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file.toml");
        write(&file, "7, 8");
        let sweep = SweepFile::read(&file).unwrap();
        assert!(sweep.tasks.iter().all(|task| task.submitted.is_none()));
        std::fs::write(&file, sweep.frozen(&sweep.out).unwrap()).unwrap();
        for (task, before) in SweepFile::read(&file).unwrap().tasks.iter().zip(&sweep.tasks) {
            assert_eq!(task.fingerprint, before.fingerprint);
            assert_eq!(task.submitted.as_ref(), Some(&before.fingerprint));
        }
    }

    #[test]
    fn a_setting_among_the_options_is_told_where_it_goes() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file.toml");
        std::fs::write(&file, "[all]\nbatch = 8\n").unwrap();
        let error = format!("{:#}", SweepFile::read(&file).err().unwrap());
        assert!(error.ends_with("; a method's setting goes into set = [\"KEY=VALUE\"]"), "{error}");
        assert!(!error.contains("tip:"), "{error}");
    }
}
