//! Claims, judged, as tables.

use copq::{Error, Result};
use maud::{Markup, html};
use serde::Serialize;

use super::claims::{Comparison, Judged, Verdict};
use super::paper::LIMIT;
use super::table::{markdown_row, number};
use crate::numbers::grouped;
use crate::statistics::Sample;

/// How to read the table.
const NOTE: &str = "\
     A claim is seen, or contradicted, where the interval of the difference over seeds says so \
     (Welch's at 95 %, from three seeds of each on; Student's, where the other is a limit). Both \
     are taken up to one step, each to its last evaluation by then; the last five are five, \
     however many steps they span. A row is of one task: it cannot refute a sentence about some \
     of them. Intervals take seeds for normal: where one seed in ten of one method alone is \
     stuck, a difference of means that is not there may be seen up to half of the time, and \
     where some of both are, hardly ever. The paper's own numbers are \
     judged likewise, their deviations taken as divided by n. Seeds that would decide: with so \
     many of each, four times in five, if means and scatter are truly those of the runs or, where \
     these have too few seeds, of the paper (p): of few seeds a guess.";
const HEAD: [&str; 8] =
    ["claim", "task", "of what", "verdict", "the paper's", "would decide", "difference", "runs"];

/// A claim's line, in words.
struct Words {
    claim: String,
    cells: [String; 7],
}

impl Judged<'_> {
    fn words(&self) -> Words {
        let claim = self.claim;
        let quantity = claim.quantity.as_deref().unwrap_or("total");
        let within = claim.within.map_or(String::new(), |share| format!(" by {share}"));
        let (of, is) = (claim.of.words(), claim.is.words());
        let what = format!("{quantity}, {of}: {} {is} {}{within}", self.method, self.than);
        let [end, wanted] = self.steps;
        let is_final =
            self.is_over() || matches!(self.verdict(), Verdict::TooFewSeeds | Verdict::TooEarly);
        let so_far = if is_final { "" } else { " so far" };
        let verdict = format!("{}{so_far}", self.verdict().words());
        let whose = if self.verdict() == Verdict::TooFewSeeds { " (p)" } else { "" };
        let decide = self.to_decide_by().map_or(String::new(), |by| {
            let seeds = by.seeds_to_decide(claim);
            seeds.map_or("over 10,000".to_owned(), |seeds| grouped(seeds as u64)) + whose
        });
        let steps = match self.has_ended {
            true => grouped(end),
            false => format!("{} of {}", grouped(end), grouped(wanted)),
        };
        let [planned, others] = self.planned;
        let runs = self.runs.map_or(String::new(), |Comparison { ours, theirs }| {
            let than = if self.than == LIMIT { "the limit, " } else { "" };
            let (ours, theirs) = (shown(&ours, planned), shown(&theirs, others));
            format!("{ours} to {than}{theirs}, at {steps} steps")
        });
        Words {
            claim: format!("{} ({})", claim.says, claim.source),
            cells: [
                self.task.clone(),
                what,
                verdict,
                self.verdict_of_paper().map_or(String::new(), |verdict| verdict.words().to_owned()),
                decide,
                self.runs.map_or(String::new(), |runs| difference(&runs)),
                runs,
            ],
        }
    }
}

/// Mean and standard deviation (divided by n, as elsewhere in the report), and how many of the
/// planned seeds there are.
fn shown(sample: &Sample, planned: usize) -> String {
    let mean = number(sample.mean, sample.mean.abs());
    let n = sample.seeds;
    let seeds = if planned > n { format!("{n} of {planned}") } else { n.to_string() };
    match n {
        _ if sample.is_exact() => mean,
        0 | 1 => format!("{mean} ({seeds})"),
        n => {
            let std = sample.std * ((n - 1) as f64 / n as f64).sqrt();
            format!("{mean} ± {} ({seeds})", number(std, sample.mean.abs()))
        }
    }
}

fn difference(runs: &Comparison) -> String {
    let Some([low, high]) = runs.ours.difference(&runs.theirs) else { return String::new() };
    let size = low.abs().max(high.abs());
    let [middle, low, high] =
        [runs.ours.mean - runs.theirs.mean, low, high].map(|value| number(value, size));
    format!("{middle} [{low}, {high}]")
}

/// As Markdown.
pub(super) fn markdown(judged: &[Judged<'_>]) -> String {
    let row = |judged: &Judged<'_>| {
        let Words { claim, cells } = judged.words();
        markdown_row(&[&[claim][..], &cells].concat())
    };
    let rows: String = judged.iter().map(row).collect();
    let head = markdown_row(&HEAD.map(str::to_owned));
    format!("{NOTE}\n\n{head}{}|\n{rows}", "|---".repeat(HEAD.len()))
}

/// For the page; a repeated claim is shown once.
pub(super) fn page(judged: &[Judged<'_>]) -> Markup {
    let rows: Vec<Words> = judged.iter().map(Judged::words).collect();
    let is_new = |i: usize| i == 0 || rows[i].claim != rows[i - 1].claim;
    html! {
        h2 id="claims" { "Claims" }
        p.note { (NOTE) }
        div.wide {
            table id="table-claims" {
                thead { tr { @for head in HEAD { th { (head) } } } }
                tbody {
                    @for (i, row) in rows.iter().enumerate() {
                        tr {
                            td.text { @if is_new(i) { (row.claim) } }
                            @for (cell, text) in row.cells.iter().enumerate() {
                                td class=[[1, 6].contains(&cell).then_some("text")] { (text) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A line of the CSV: every number in its own column, standard deviations divided by n - 1.
#[derive(Serialize)]
struct Line<'a> {
    claim: &'a str,
    source: &'a str,
    task: &'a str,
    of: &'static str,
    quantity: Option<&'a str>,
    method: &'a str,
    is: &'static str,
    than: &'a str,
    within: Option<f64>,
    verdict: &'static str,
    paper_verdict: Option<&'static str>,
    seeds_to_decide: Option<usize>,
    is_over: bool,
    steps: u64,
    steps_wanted: u64,
    mean: Option<f64>,
    std: Option<f64>,
    seeds: Option<usize>,
    seeds_wanted: usize,
    than_mean: Option<f64>,
    than_std: Option<f64>,
    than_seeds: Option<usize>,
    than_seeds_wanted: usize,
    difference_low: Option<f64>,
    difference_high: Option<f64>,
}

impl<'a> Line<'a> {
    fn of(judged: &'a Judged<'_>) -> Self {
        let claim = judged.claim;
        let ours = judged.runs.map(|runs| runs.ours);
        let theirs = judged.runs.map(|runs| runs.theirs);
        let ends = ours.zip(theirs).and_then(|(ours, theirs)| ours.difference(&theirs));
        // One seed has no deviation, and a limit no seeds.
        let std = |sample: Sample| Some(sample.std).filter(|std| std.is_finite());
        let seeds = |sample: Sample| (!sample.is_exact()).then_some(sample.seeds);
        Self {
            claim: &claim.says,
            source: &claim.source,
            task: &judged.task,
            of: claim.of.words(),
            quantity: claim.quantity.as_deref(),
            method: judged.method,
            is: claim.is.words(),
            than: judged.than,
            within: claim.within,
            verdict: judged.verdict().words(),
            paper_verdict: judged.verdict_of_paper().map(Verdict::words),
            seeds_to_decide: judged.to_decide_by().and_then(|by| by.seeds_to_decide(claim)),
            is_over: judged.is_over(),
            steps: judged.steps[0],
            steps_wanted: judged.steps[1],
            mean: ours.map(|ours| ours.mean),
            std: ours.and_then(std),
            seeds: ours.map(|ours| ours.seeds),
            seeds_wanted: judged.planned[0],
            than_mean: theirs.map(|theirs| theirs.mean),
            than_std: theirs.and_then(std),
            than_seeds: theirs.and_then(seeds),
            than_seeds_wanted: judged.planned[1],
            difference_low: ends.map(|[low, _]| low),
            difference_high: ends.map(|[_, high]| high),
        }
    }
}

/// As CSV.
pub(super) fn csv(judged: &[Judged<'_>]) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let failed = |error: csv::Error| Error::other("encoding claims", error);
    judged.iter().try_for_each(|judged| writer.serialize(Line::of(judged)).map_err(failed))?;
    writer.into_inner().map_err(|e| Error::other("encoding claims", e.into_error()))
}
