//! The page.

use std::collections::BTreeMap;
use std::time::Duration;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use copq::{Error, Result};
use copq_render::label_sample;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::Report;
use super::curves::Curves;
use super::groups::{World, flatten};
use super::stored::Stored;
use super::tables::{READING, Table};
use crate::config::MadeWith;
use crate::numbers::{duration, grouped};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// What the ellipses are.
const ELLIPSES: &str = "One standard deviation of the critics' values of replayed actions, early, half-way and last \
     in training (from q_std and correlation in metrics.csv, around 0), and where each projection would \
     put the lower bound at the end, by the task's weights. One seed a method.";
/// Most runs whose seeds are drawn one by one, and whose figures are drawn for a phone, too: a page of
/// more is too large for one.
const SEEDS: usize = 1_000;
/// Most runs in the list; the failed ones come first.
const LISTED: usize = 2_000;

pub(super) fn render(report: &Report, every: Option<Duration>) -> Result<String> {
    let worlds = &report.groups.worlds;
    let with_seeds = report.runs.len() <= SEEDS;
    let curves: Vec<Markup> = worlds
        .iter()
        .map(|world| match report.curves(world, with_seeds) {
            curves if curves.is_empty() => Ok(html! { p { (world.name) ": no evaluation yet" } }),
            curves => figure(&curves, with_seeds),
        })
        .collect::<Result<_>>()?;
    let diagnostics: Vec<Markup> = report
        .diagnostics()
        .iter()
        .map(|curves| figure(curves, with_seeds))
        .collect::<Result<_>>()?;
    let planes: Vec<String> =
        report.planes().iter().map(|(_, plane)| plane.svg()).collect::<Result<_>>()?;
    let ellipses: Vec<String> =
        report.ellipses().iter().map(|(_, plane)| plane.svg()).collect::<Result<_>>()?;
    let films: Vec<Markup> = worlds.iter().flat_map(|world| films(report, world)).collect();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                @if let Some(every) = every {
                    meta http-equiv="refresh" content=(every.as_secs().max(1));
                }
                title { (report.title) }
                style { (PreEscaped(STYLE)) (PreEscaped(hiding(report.groups.labels.len()))) }
            }
            body {
                h1 { (report.title) }
                p { (report.summary()) }
                (keys(report, with_seeds))
                h2 id="curves" { "Evaluations" }
                @for figure in &curves { (figure) }
                @if !planes.is_empty() {
                    h2 id="costs" { "Reward against cost" }
                    p.note { "A dot a seed: means of the last five evaluations. Dashed: the limit." }
                    div.films { @for plane in planes { figure.by-method { (PreEscaped(plane)) } } }
                }
                @if !films.is_empty() {
                    h2 id="films" { "Policies at work" }
                    div.films { @for film in &films { (film) } }
                }
                h2 id="tables" { "Tables" }
                p.note { (READING) }
                @for table in report.tables() { (table_of(&table)) }
                @if !diagnostics.is_empty() {
                    h2 id="training" { "In training" }
                    @for figure in &diagnostics { (figure) }
                }
                @if !ellipses.is_empty() {
                    h2 id="ellipses" { "What the critics disagree about" }
                    p.note { (ELLIPSES) }
                    div.films { @for plane in ellipses { figure { (PreEscaped(plane)) } } }
                }
                (troubles(report))
                h2 id="settings" { "Settings" }
                (settings(report))
                h2 id="builds" { "Made by" }
                (builds(report))
                h2 id="runs" { "Runs" }
                (runs(report))
                script { (PreEscaped(SCRIPT)) }
            }
        }
    };
    Ok(page.into_string())
}

/// Style that shows and hides each method by its box, without a script.
fn hiding(labels: usize) -> String {
    let rule = |i| format!("body:has(#m{i}:not(:checked)) .by-method .s{i} {{ display: none; }}\n");
    (0..labels).map(rule).collect()
}

fn keys(report: &Report, with_seeds: bool) -> Markup {
    html! {
        div.keys {
            @for (i, label) in report.groups.labels.iter().enumerate() {
                label {
                    input type="checkbox" id=(format!("m{i}")) checked;
                    " "
                    (PreEscaped(label_sample(i)))
                    (label)
                }
            }
            @if with_seeds {
                label { input type="checkbox" id="seeds"; " each seed" }
            }
        }
    }
}

/// Curves as a picture, with their numbers for the script, and as another one for a phone.
fn figure(curves: &Curves, for_phone: bool) -> Result<Markup> {
    let numbers = serde_json::to_string(curves).map_err(|e| Error::other("writing curves", e))?;
    Ok(html! {
        figure.curves.by-method.wide {
            (PreEscaped(curves.figure().svg()?))
            // A text in it must not end the element.
            script type="application/json" { (PreEscaped(numbers.replace('<', "\\u003c"))) }
        }
        @if for_phone {
            figure.curves.by-method.narrow { (PreEscaped(curves.figure().columns(1).svg()?)) }
        }
    })
}

fn table_of(table: &Table) -> Markup {
    html! {
        h3 { (table.title) }
        p.note { (table.note) }
        div.wide {
            table id=(format!("table-{}", table.name)) {
                thead { tr { th { "method" } @for column in &table.columns { th { (column) } } } }
                tbody {
                    @for (label, cells) in &table.rows {
                        tr {
                            td { (label) }
                            @for cell in cells {
                                td.bad[cell.is_violated] { (cell.plain()) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The films of a task that lie in its runs' folders, one a method.
fn films(report: &Report, world: &World) -> Vec<Markup> {
    let labels = report.groups.labels.iter().zip(&world.runs);
    let film = |(label, numbers): (&String, &Vec<usize>)| {
        let runs = numbers.iter().map(|&number| &report.runs[number]);
        let found = runs.filter_map(|run| Some((run, run.film()?))).next();
        let (run, bytes) = found?;
        let source = format!("data:image/gif;base64,{}", BASE64_STANDARD.encode(bytes));
        let seed = run.plan().map_or(String::new(), |plan| format!(", seed {}", plan.run.seed));
        let words = format!("{label} on {}{seed}", world.short);
        Some(html! {
            figure {
                img src=(source) alt=(words) loading="lazy";
                figcaption.note { (words) }
            }
        })
    };
    labels.filter_map(film).collect()
}

/// What went wrong, and what could not be read.
fn troubles(report: &Report) -> Markup {
    let troubled: Vec<&Stored> =
        report.runs.iter().filter(|run| !run.troubles().is_empty()).collect();
    html! {
        @if !troubled.is_empty() {
            h2 id="failures" { "Failures" }
            ul {
                @for run in troubled {
                    li.bad { (run.run.folder.display()) ": " (run.troubles().join("; ")) }
                }
            }
        }
    }
}

/// Every method's settings, those in which methods differ first.
fn settings(report: &Report) -> Markup {
    let mut first: Vec<Option<&Stored>> = vec![None; report.groups.labels.len()];
    for world in report.groups.worlds.iter().rev() {
        for (label, numbers) in world.runs.iter().enumerate() {
            first[label] = numbers.first().map(|&n| &report.runs[n]).or(first[label]);
        }
    }
    let all: Vec<BTreeMap<String, String>> = first.iter().map(|run| all_settings(*run)).collect();
    let mut names: Vec<&String> = all.iter().flat_map(BTreeMap::keys).collect();
    names.sort();
    names.dedup();
    let differs = |name: &&&String| all.iter().any(|one| one.get(**name) != all[0].get(**name));
    let differing: Vec<&&String> = names.iter().filter(differs).collect();
    html! {
        @if differing.is_empty() {
            p { "No setting differs." }
        } @else {
            div.wide {
                table id="differences" {
                    thead { tr {
                        th { "setting" }
                        @for label in &report.groups.labels { th { (label) } }
                    } }
                    tbody {
                        @for name in differing {
                            tr {
                                td { (name) }
                                @for one in &all {
                                    td { (one.get(*name).map_or("", String::as_str)) }
                                }
                            }
                        }
                    }
                }
            }
        }
        @for (label, run) in report.groups.labels.iter().zip(&first) {
            @if let Some((plan, settings)) = run.and_then(|run| run.what.as_ref()) {
                details {
                    summary { "All settings of " (label) }
                    pre {
                        @if let Some(run) = run { "# " (command(run)) "\n\n" }
                        (toml::to_string(plan).unwrap_or_default()) "\n" (settings.to_string())
                    }
                }
            }
        }
    }
}

fn all_settings(run: Option<&Stored>) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    if let Some((plan, settings)) = run.and_then(|run| run.what.as_ref()) {
        let plan = toml::Table::try_from(plan).unwrap_or_default();
        flatten("", &plan.into(), &mut all);
        all.retain(|name, _| name != "run.seed" && name != "task");
        flatten("", &crate::config::complete(settings).into(), &mut all);
    }
    all
}

/// Which programs on which machines.
fn builds(report: &Report) -> Markup {
    let mut builds: Vec<(&MadeWith, usize, f64, Vec<f64>)> = Vec::new();
    for run in &report.runs {
        let Some(config) = &run.config else { continue };
        let made = &config.made_with;
        let same = |other: &&mut (&MadeWith, usize, f64, Vec<f64>)| {
            let other = other.0;
            (&other.copq, &other.build, &other.rustc, &other.processor)
                == (&made.copq, &made.build, &made.rustc, &made.processor)
        };
        match builds.iter_mut().find(same) {
            Some((_, count, seconds, rates)) => {
                *count += 1;
                *seconds += run.seconds;
                rates.push(run.rate);
            }
            None => builds.push((made, 1, run.seconds, vec![run.rate])),
        }
    }
    html! {
        div.wide {
            table {
                thead { tr {
                    th { "program" } th { "compiler" } th { "system" } th { "processor" }
                    th { "runs" } th { "time" } th { "steps/s (median)" }
                } }
                tbody {
                    @for (made, count, seconds, rates) in builds {
                        tr {
                            td { (made.version()) } td { (made.rustc) } td { (made.system) }
                            td { (made.processor) } td { (count) }
                            td { (duration(seconds)) } td { (rate(&rates)) }
                        }
                    }
                }
            }
        }
    }
}

fn rate(rates: &[f64]) -> String {
    let known: Vec<f64> = rates.iter().copied().filter(|rate| rate.is_finite()).collect();
    if known.is_empty() {
        return String::new();
    }
    format!("{:.0}", crate::statistics::median(&known))
}

fn runs(report: &Report) -> Markup {
    let mut runs: Vec<&Stored> = report.runs.iter().collect();
    runs.sort_by_key(|run| run.standing.word() != "failed");
    let more = runs.len().saturating_sub(LISTED);
    html! {
        div.wide {
            table id="list" {
                thead { tr {
                    th { "run" } th { "state" } th { "steps" } th { "of" } th { "time" }
                    th { "steps/s" }
                } }
                tbody {
                    @for run in runs.iter().take(LISTED) {
                        tr {
                            td { (run.name()) } td { (run.standing.word()) }
                            td { (grouped(run.steps)) }
                            td { (run.plan().map_or(String::new(), |plan| grouped(plan.run.steps))) }
                            td { (duration(run.seconds)) } td { (rate(&[run.rate])) }
                        }
                    }
                }
            }
        }
        @if more > 0 { p { "And " (more) " more." } }
    }
}

fn command(run: &Stored) -> String {
    run.config.as_ref().map_or(String::new(), |config| config.made_with.command.join(" "))
}

impl Stored {
    /// Its failure and what of it could not be read.
    fn troubles(&self) -> Vec<&str> {
        let failure = match &self.standing {
            crate::standing::Standing::Failed(error) => Some(error.as_str()),
            _ => None,
        };
        failure.into_iter().chain(self.problems.iter().map(String::as_str)).collect()
    }

    /// The film that copq rollout has left in its folder.
    fn film(&self) -> Option<Vec<u8>> {
        std::fs::read(self.run.folder.join("rollout.gif")).ok()
    }
}
