//! The page.

use std::path::PathBuf;
use std::time::Duration;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use copq::{Error, Result};
use copq_render::label_sample;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::Report;
use super::claims_table;
use super::curves::Curves;
use super::groups::World;
use super::provenance::{builds, runs, settings, troubles};
use super::stored::Stored;
use super::table::{READING, Table};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// What the ellipses are.
const ELLIPSES: &str = "One standard deviation of the critics' values of replayed actions, early, half-way and last \
     in training (from q_std and correlation in metrics.csv, around 0), and where each projection would \
     put the lower bound of these two at the end, by the task's weights or a cost's multiplier. Other objectives, \
     which can change the clip, eigen's bound and extremum's, are left out. One seed a method.";
/// The most runs for which seeds are drawn one by one, and figures also for a phone: a page with
/// more is too large for one.
const SEEDS: usize = 1_000;
/// The most bytes of all films on a page, for the same reason.
const FILMS: u64 = 20_000_000;

pub(super) fn render(report: &Report, every: Option<Duration>) -> Result<String> {
    let with_seeds = report.runs.len() <= SEEDS;
    let curves = curves(report, with_seeds)?;
    let training = training(report, with_seeds)?;
    let pictures = html! {
        (planes(report)?)
        (profiles(report)?)
        (films(report, FILMS))
    };
    let judged = report.judged();
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(report, every))
            body {
                h1 { (report.title) }
                p { (report.summary()) }
                (keys(report, with_seeds))
                (curves)
                (pictures)
                h2 id="tables" { "Tables" }
                p.note { (READING) }
                @for table in report.tables() { (table_of(&table)) }
                @if !judged.is_empty() { (claims_table::page(&judged)) }
                (training)
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

/// All tasks together.
fn profiles(report: &Report) -> Result<Markup> {
    let picture = report.profiles().map(|figure| figure.svg()).transpose()?;
    Ok(html! {
        @if let Some(picture) = picture {
            h2 id="together" { "All tasks together" }
            figure.by-method.alone { (PreEscaped(picture)) }
        }
    })
}

fn head(report: &Report, every: Option<Duration>) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            @if let Some(every) = every {
                meta http-equiv="refresh" content=(every.as_secs().max(1));
            }
            title { (report.title) }
            style { (PreEscaped(STYLE)) (PreEscaped(hiding(report.groups.labels.len()))) }
        }
    }
}

/// The evaluations of every task.
fn curves(report: &Report, with_seeds: bool) -> Result<Markup> {
    let worlds = report.groups.worlds.iter();
    let figures = worlds.map(|world| match report.curves(world, with_seeds) {
        curves if curves.is_empty() => Ok(html! { p { (world.name) ": no evaluation yet" } }),
        curves => figure(&curves, with_seeds),
    });
    let figures = figures.collect::<Result<Vec<Markup>>>()?;
    Ok(html! {
        h2 id="curves" { "Evaluations" }
        @for figure in &figures { (figure) }
    })
}

/// Rewards against costs, where costs have limits.
fn planes(report: &Report) -> Result<Markup> {
    let planes = report.planes();
    let planes = planes.iter().map(|(_, plane)| plane.svg()).collect::<Result<Vec<_>>>()?;
    Ok(html! {
        @if !planes.is_empty() {
            h2 id="costs" { "Reward against cost" }
            p.note { "A dot a seed: means of the last five evaluations. Dashed: the limit." }
            div.films { @for plane in planes { figure.by-method { (PreEscaped(plane)) } } }
        }
    })
}

/// Training's own numbers, and what the critics disagreed about.
fn training(report: &Report, with_seeds: bool) -> Result<Markup> {
    let figures = report.diagnostics();
    let figures = figures.iter().map(|curves| figure(curves, with_seeds));
    let figures = figures.collect::<Result<Vec<Markup>>>()?;
    let ellipses = report.ellipses();
    let ellipses = ellipses.iter().map(|(_, plane)| plane.svg()).collect::<Result<Vec<_>>>()?;
    Ok(html! {
        @if !figures.is_empty() {
            h2 id="training" { "In training" }
            @for figure in &figures { (figure) }
        }
        @if !ellipses.is_empty() {
            h2 id="ellipses" { "What the critics disagree about" }
            p.note { (ELLIPSES) }
            div.films { @for plane in ellipses { figure { (PreEscaped(plane)) } } }
        }
    })
}

/// CSS that shows and hides each method with its checkbox, without a script.
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
                                td class=[cell.is_violated.then_some("bad")] { (cell.plain()) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The films in the runs' folders, one per method and task, as many as there is room for.
pub(super) fn films(report: &Report, mut room: u64) -> Markup {
    let (mut shown, mut left_out) = (Vec::new(), 0);
    for world in &report.groups.worlds {
        for (label, numbers) in report.groups.labels.iter().zip(&world.runs) {
            let mut runs = numbers.iter().map(|&number| &report.runs[number]);
            let found = runs.find_map(|run| Some((run, run.film_size()?)));
            let Some((run, size)) = found else { continue };
            match room.checked_sub(size) {
                Some(rest) => {
                    room = rest;
                    shown.extend(film(run, label, world));
                }
                None => left_out += 1,
            }
        }
    }
    html! {
        @if !shown.is_empty() || left_out > 0 {
            h2 id="films" { "Policies at work" }
            @if left_out > 0 {
                p.note {
                    (left_out) " more would exceed the " (FILMS / 1_000_000)
                    " MB that a page has for films. They lie in their runs' folders, as rollout.gif."
                }
            }
            div.films { @for film in &shown { (film) } }
        }
    }
}

fn film(run: &Stored, label: &str, world: &World) -> Option<Markup> {
    let bytes = std::fs::read(run.film()).ok()?;
    let source = format!("data:image/gif;base64,{}", BASE64_STANDARD.encode(bytes));
    let seed = run.plan().map_or(String::new(), |plan| format!(", seed {}", plan.run.seed));
    let words = format!("{label} on {}{seed}", world.short);
    Some(html! {
        figure {
            img src=(source) alt=(words) loading="lazy";
            figcaption.note { (words) }
        }
    })
}

impl Stored {
    /// The film that copq rollout leaves in its folder.
    fn film(&self) -> PathBuf {
        self.run.folder.join("rollout.gif")
    }

    /// Its size, if it is there.
    fn film_size(&self) -> Option<u64> {
        Some(std::fs::metadata(self.film()).ok()?.len())
    }
}
