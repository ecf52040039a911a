//! What made the runs, and what became of them: failures, settings, programs, the list of all runs.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::Report;
use super::groups::flatten;
use super::stored::Stored;
use crate::config::MadeWith;
use crate::numbers::{duration, grouped};

/// Most runs in the list; the failed ones come first.
const LISTED: usize = 2_000;

/// What went wrong, and what could not be read.
pub(super) fn troubles(report: &Report) -> Markup {
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
pub(super) fn settings(report: &Report) -> Markup {
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
pub(super) fn builds(report: &Report) -> Markup {
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

pub(super) fn runs(report: &Report) -> Markup {
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
                            td { (run.steps_wanted().map_or(String::new(), grouped)) }
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
    /// Its failure, and what could not be read of it.
    fn troubles(&self) -> Vec<&str> {
        let failure = match &self.standing {
            crate::standing::Standing::Failed(error) => Some(error.as_str()),
            _ => None,
        };
        failure.into_iter().chain(self.problems.iter().map(String::as_str)).collect()
    }
}
