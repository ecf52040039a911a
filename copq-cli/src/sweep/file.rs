//! A sweep's file: options of `copq train`, in products and by name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::Parser;
use serde::Deserialize;

use crate::train::{Prepared, Train};

/// Options of copq train by their long names; `method` is the method, `set` a list.
type Options = BTreeMap<String, toml::Value>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    /// The folder of all runs. [default: runs/ and the file's name]
    out: Option<PathBuf>,
    /// The product of these lists, option by option.
    #[serde(default)]
    grid: BTreeMap<String, Vec<toml::Value>>,
    /// Named variants, each with options of its own; every one is run over the whole grid.
    #[serde(default)]
    arm: Vec<Options>,
    /// Combinations to leave out: those that have all of an entry's options.
    #[serde(default)]
    exclude: Vec<Options>,
    /// Combinations to add: options over those of all runs.
    #[serde(default)]
    include: Vec<Options>,
    /// Options of all runs.
    #[serde(default)]
    all: Options,
}

/// What a sweep's file comes to.
pub struct SweepFile {
    pub tasks: Vec<Task>,
}

/// One run.
pub struct Task {
    pub folder: PathBuf,
    arguments: Vec<String>,
}

/// `copq train` alone, so that a task's options are read as its.
#[derive(Parser)]
struct Line {
    #[command(flatten)]
    train: Train,
}

impl Task {
    /// As somebody would type it.
    pub fn command(&self) -> String {
        format!("copq train {}", self.arguments.join(" "))
    }

    /// What it would train; an error for options that do not fit.
    pub fn prepare(&self) -> anyhow::Result<Prepared> {
        prepare(&self.arguments)
    }
}

fn prepare(arguments: &[String]) -> anyhow::Result<Prepared> {
    let words = std::iter::once("copq train").chain(arguments.iter().map(String::as_str));
    let line = Line::try_parse_from(words).map_err(|error| {
        let text = error.to_string();
        let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
        anyhow::anyhow!("{first}")
    })?;
    line.train.prepare()
}

impl SweepFile {
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("reading '{shown}'"))?;
        let raw: Raw = toml::from_str(&text).with_context(|| format!("'{shown}'"))?;
        let stem = path.file_stem().unwrap_or_default();
        let out = raw.out.clone().unwrap_or_else(|| Path::new("runs").join(stem));
        let mut tasks = Vec::new();
        let mut names = BTreeSet::new();
        for (name, options) in raw.combinations()? {
            let arguments = arguments(&options)?;
            let prepared = prepare(&arguments)
                .with_context(|| format!("'{shown}', copq train {}", arguments.join(" ")))?;
            let folder = name.map_or(String::new(), |name| name + "-") + &prepared.name;
            ensure!(
                names.insert(folder.clone()),
                "'{shown}': wanted each run once, got {folder} twice"
            );
            tasks.push(Task { folder: out.join(folder), arguments });
        }
        ensure!(
            !tasks.is_empty(),
            "'{shown}': wanted one run at least (a [grid] of lists), got none"
        );
        Ok(Self { tasks })
    }
}

impl Raw {
    /// The options of every run, and the name of its arm.
    fn combinations(&self) -> anyhow::Result<Vec<(Option<String>, Options)>> {
        let mut product = vec![self.all.clone()];
        for (option, values) in &self.grid {
            product = product
                .iter()
                .flat_map(|options| {
                    values.iter().map(|value| with(options, [(option.clone(), value.clone())]))
                })
                .collect();
        }
        let mut all = Vec::new();
        for options in product.iter().filter(|_| !self.grid.is_empty() || !self.arm.is_empty()) {
            for arm in self.arm.iter().map(Some).chain(self.arm.is_empty().then_some(None)) {
                let (name, arm) = named(arm)?;
                all.push((name, with(options, arm)));
            }
        }
        all.retain(|(_, options)| {
            let has = |(option, value): (&String, &toml::Value)| options.get(option) == Some(value);
            !self.exclude.iter().any(|excluded| excluded.iter().all(has))
        });
        for include in &self.include {
            let (name, options) = named(Some(include))?;
            all.push((name, with(&self.all, options)));
        }
        Ok(all)
    }
}

/// An arm's name and its options.
fn named(arm: Option<&Options>) -> anyhow::Result<(Option<String>, Options)> {
    let Some(mut options) = arm.cloned() else { return Ok((None, Options::new())) };
    match options.remove("name") {
        None => Ok((None, options)),
        Some(toml::Value::String(name)) => Ok((Some(name), options)),
        Some(other) => bail!("name of an arm: wanted a text, got {other}"),
    }
}

/// Options over others; lists of settings add up.
fn with(base: &Options, over: impl IntoIterator<Item = (String, toml::Value)>) -> Options {
    let mut options = base.clone();
    for (name, value) in over {
        match (options.get_mut(&name), value) {
            (Some(toml::Value::Array(old)), toml::Value::Array(new)) => old.extend(new),
            (_, value) => drop(options.insert(name, value)),
        }
    }
    options
}

fn arguments(options: &Options) -> anyhow::Result<Vec<String>> {
    let mut arguments = Vec::new();
    for (name, value) in options {
        ensure!(name != "out", "out: wanted it for the whole sweep, got it for a run");
        match (name.as_str(), value) {
            ("method", value) => arguments.insert(0, plain(name, value)?),
            (_, toml::Value::Array(values)) => {
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
