//! Which runs are seeds of one method, and which tasks there are.

use std::collections::{BTreeMap, BTreeSet};

use super::stored::Stored;
use crate::config::complete;
use crate::plan::Plan;

/// More settings than this do not make a name.
const NAMED: usize = 3;

/// All runs, sorted by method and task.
#[derive(Clone, Debug, Default)]
pub(crate) struct Groups {
    /// The methods' names, in the runs' order; a method's number is its colour.
    pub labels: Vec<String>,
    /// Each method's name without what sets it apart from others.
    bases: Vec<String>,
    /// The tasks, in the runs' order.
    pub worlds: Vec<World>,
}

/// A task on its engine, with the runs of each method.
#[derive(Clone, Debug)]
pub(crate) struct World {
    /// Task, engine and preset, and the limits if only these tell two apart.
    pub name: String,
    /// The task, or the whole name if another has the same task.
    pub short: String,
    /// The task alone.
    pub task: String,
    /// The limits of its costs.
    pub limits: BTreeMap<String, f64>,
    /// The weights of its objectives.
    pub weights: BTreeMap<String, f64>,
    /// The numbers of the runs of each label.
    pub runs: Vec<Vec<usize>>,
}

impl Groups {
    /// Sorts the runs. Among several runs of one seed, the longest counts, and the others say so.
    pub(crate) fn of(runs: &mut [Stored]) -> Self {
        let mut groups = Self::default();
        for (number, label) in labels(runs).into_iter().enumerate() {
            let run = &runs[number];
            let label =
                position_or_push(&mut groups.labels, |known| *known == label, || label.clone());
            if groups.bases.len() < groups.labels.len() {
                groups.bases.push(base(run));
            }
            let name = run.plan().map_or_else(|| "unknown".to_owned(), world_name);
            let world = position_or_push(
                &mut groups.worlds,
                |world| world.name == name && world.limits == run.run.limits,
                || World {
                    name: name.clone(),
                    short: String::new(),
                    task: run.plan().map_or_else(|| name.clone(), |plan| plan.task.clone()),
                    limits: run.run.limits.clone(),
                    weights: run.run.weights.clone(),
                    runs: Vec::new(),
                },
            );
            let of_labels = &mut groups.worlds[world].runs;
            of_labels.resize_with(of_labels.len().max(label + 1), Vec::new);
            of_labels[label].push(number);
        }
        for world in &mut groups.worlds {
            world.runs.resize_with(groups.labels.len(), Vec::new);
            for numbers in &mut world.runs {
                keep_one_a_seed(numbers, runs);
                tell_apart(numbers, runs);
            }
        }
        groups.name_worlds();
        groups
    }

    /// The method with this name on a task: by its whole name, or by its first part if no other
    /// name there begins with it.
    pub(crate) fn method(&self, world: &World, name: &str) -> Option<usize> {
        let is_there = |label: &usize| !world.runs[*label].is_empty();
        let whole = self.labels.iter().position(|label| label == name);
        let mut parts = (0..self.bases.len()).filter(|&i| self.bases[i] == name).filter(is_there);
        whole.filter(is_there).or_else(|| parts.next().filter(|_| parts.next().is_none()))
    }

    /// The names of the methods on a task.
    pub(crate) fn methods<'a>(&'a self, world: &World) -> Vec<&'a str> {
        let names = self.bases.iter().chain(&self.labels).map(String::as_str);
        let known: BTreeSet<&str> =
            names.filter(|name| self.method(world, name).is_some()).collect();
        known.into_iter().collect()
    }

    /// Gives tasks names that tell them all apart.
    fn name_worlds(&mut self) {
        let count = |names: &[String], name: &String| names.iter().filter(|n| *n == name).count();
        let names: Vec<String> = self.worlds.iter().map(|world| world.name.clone()).collect();
        let tasks: Vec<String> = self.worlds.iter().map(|world| world.task.clone()).collect();
        for world in &mut self.worlds {
            if count(&names, &world.name) > 1 {
                for (cost, limit) in &world.limits {
                    world.name += &format!(", {cost} <= {limit}");
                }
            }
            let is_alone = count(&tasks, &world.task) == 1;
            world.short.clone_from(if is_alone { &world.task } else { &world.name });
        }
    }
}

/// Keeps the longest run of each seed, because a seed is one replicate.
fn keep_one_a_seed(numbers: &mut Vec<usize>, runs: &mut [Stored]) {
    let mut longest: BTreeMap<u64, usize> = BTreeMap::new();
    for &number in numbers.iter() {
        let Some(plan) = runs[number].plan() else { continue };
        let kept = longest.entry(plan.run.seed).or_insert(number);
        if runs[number].end() > runs[*kept].end() {
            *kept = number;
        }
    }
    numbers.retain(|&number| {
        let seed = runs[number].plan().map(|plan| plan.run.seed);
        let Some(&kept) = seed.and_then(|seed| longest.get(&seed)) else { return true };
        if kept != number {
            let other = runs[kept].run.folder.display().to_string();
            runs[number].problems.push(format!("not counted: {other} is the same seed"));
        }
        kept == number
    });
}

/// Seeds that are evaluated differently from the first one count, but say so.
fn tell_apart(numbers: &[usize], runs: &mut [Stored]) {
    let evaluated = |number: &usize| runs[*number].evaluated.as_ref();
    let Some(first) = numbers.iter().copied().find(|number| evaluated(number).is_some()) else {
        return;
    };
    let unlike = |number: &usize| evaluated(number)?.unlike(evaluated(&first)?);
    let apart = numbers.iter().filter_map(|number| Some((*number, unlike(number)?)));
    let apart: Vec<(usize, String)> = apart.collect();
    let name = runs[first].run.folder.display().to_string();
    for (number, words) in apart {
        let problem = format!("not evaluated as {name}, the same method: {words}");
        runs[number].problems.push(problem);
    }
}

fn position_or_push<T>(
    all: &mut Vec<T>,
    is_it: impl Fn(&T) -> bool,
    make: impl FnOnce() -> T,
) -> usize {
    all.iter().position(is_it).unwrap_or_else(|| {
        all.push(make());
        all.len() - 1
    })
}

fn world_name(plan: &Plan) -> String {
    // A task with a colon names its own package.
    let mut name = match plan.task.contains(':') {
        true => plan.task.clone(),
        false => format!("{}, {}, {}", plan.task, plan.engine, plan.preset),
    };
    // Runs in different environments are not seeds of one method.
    for (key, value) in &plan.world {
        name += &format!(", {key} {value}");
    }
    if let Some(weights) = &plan.weights {
        name += &format!(", weights {weights}");
    }
    name
}

/// The name of each run's method: its own label or method, and what sets it apart from others of
/// that name. The plan comes first, because bounds bring critics and settings with them.
fn labels(runs: &[Stored]) -> Vec<String> {
    let mut names: Vec<String> = runs.iter().map(base).collect();
    for traits in [method, of_plan, critics] {
        names = refined(names, runs, traits, |_| String::new());
    }
    // Settings that follow the task, such as the steps over which a step size falls, do not make
    // another method.
    refined(names, runs, settings, |run| run.plan().map_or_else(String::new, world_name))
}

/// The folder's name without the seed.
fn stem(run: &Stored) -> String {
    let name = run.name();
    let seed = |(_, seed): &(&str, &str)| seed.chars().all(|c| c.is_ascii_digit());
    name.rsplit_once("-s").filter(seed).map_or(name.clone(), |(stem, _)| stem.to_owned())
}

/// Names with the traits in which runs of the same name differ within a scope; if these are too
/// many, the first such run's folder gives the name.
fn refined(
    names: Vec<String>,
    runs: &[Stored],
    traits: fn(&Stored) -> Traits,
    scope: fn(&Stored) -> String,
) -> Vec<String> {
    let traits: Vec<Traits> = runs.iter().map(traits).collect();
    let scopes: Vec<String> = runs.iter().map(scope).collect();
    let apart = apart(&names, &scopes, &traits);
    let mut variants: BTreeMap<&str, Vec<(Vec<String>, String)>> = BTreeMap::new();
    let mut refined = Vec::new();
    for ((name, traits), run) in names.iter().zip(&traits).zip(runs) {
        let apart = &apart[name.as_str()];
        let parts = apart.iter().filter_map(|&trait_| Some(shown(trait_, traits.get(trait_)?)));
        let parts: Vec<String> = parts.collect();
        let known = variants.entry(name).or_default();
        let is_it = |(variant, _): &(Vec<String>, String)| *variant == parts;
        let number = position_or_push(known, is_it, || (parts.clone(), stem(run)));
        refined.push(if apart.len() > NAMED {
            // Two variants of one name are told apart by a number.
            let stem = &known[number].1;
            let namesakes = known[..number].iter().filter(|(_, other)| other == stem);
            let own = if stem.starts_with(name) { stem.clone() } else { format!("{name} {stem}") };
            match namesakes.count() {
                0 => own,
                count => format!("{own} #{}", count + 1),
            }
        } else {
            [&[name.clone()][..], &parts].concat().join(" ")
        });
    }
    refined
}

/// The traits of each name in which two of its runs differ within a scope; to lack one is also to
/// differ.
fn apart<'a>(
    names: &'a [String],
    scopes: &'a [String],
    traits: &'a [Traits],
) -> BTreeMap<&'a str, BTreeSet<&'a str>> {
    let mut all: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (name, traits) in names.iter().zip(traits) {
        all.entry(name).or_default().extend(traits.keys().map(String::as_str));
    }
    let mut first: BTreeMap<(&str, &str, &str), Option<&String>> = BTreeMap::new();
    let mut apart: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for ((name, scope), traits) in names.iter().zip(scopes).zip(traits) {
        let of_name = apart.entry(name).or_default();
        for &trait_ in &all[name.as_str()] {
            let value = traits.get(trait_);
            if *first.entry((name, scope, trait_)).or_insert(value) != value {
                of_name.insert(trait_);
            }
        }
    }
    apart
}

fn base(run: &Stored) -> String {
    let method = || run.plan().map(|plan| plan.method.clone());
    run.run.label.clone().or_else(method).unwrap_or_else(|| run.name())
}

/// A trait as a part of a name: the bound and the order speak for themselves.
fn shown(name: &str, value: &str) -> String {
    match name {
        "method" | "bound" | "order" => value.to_owned(),
        _ => format!("{name}={value}"),
    }
}

/// What can set a method apart, by name.
type Traits = BTreeMap<String, String>;

fn method(run: &Stored) -> Traits {
    run.plan().map(|plan| ("method".to_owned(), plan.method.clone())).into_iter().collect()
}

fn of_plan(run: &Stored) -> Traits {
    let Some(plan) = run.plan() else { return Traits::new() };
    let from = plan.init_from.as_ref().map(|from| from.display().to_string());
    let envs = (plan.envs > 1).then(|| plan.envs.to_string());
    let traits = [
        ("bound", plan.bound.clone()),
        ("order", plan.order.clone()),
        ("envs", envs),
        ("from", from),
        ("policy", plan.init_checksum.clone()),
    ];
    traits.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

fn critics(run: &Stored) -> Traits {
    let critics = run.plan().and_then(|plan| plan.critics);
    critics.map(|critics| ("critics".to_owned(), format!("{critics:?}"))).into_iter().collect()
}

fn settings(run: &Stored) -> Traits {
    let mut traits = Traits::new();
    if let Some((_, settings)) = &run.what {
        flatten("", &complete(settings).into(), &mut traits);
    }
    traits
}

/// A table's values by their names, whose parts are joined by dots.
pub(crate) fn flatten(key: &str, value: &toml::Value, all: &mut BTreeMap<String, String>) {
    match value {
        toml::Value::Table(table) => {
            for (name, value) in table {
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                flatten(&key, value, all);
            }
        }
        toml::Value::String(text) => drop(all.insert(key.to_owned(), text.clone())),
        value => drop(all.insert(key.to_owned(), value.to_string())),
    }
}
