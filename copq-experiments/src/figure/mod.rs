//! Figures: evaluation curves of one run or of several.

mod canvas;
mod compare;
mod curves;
mod font;
mod layout;
mod panel;
mod pen;
mod ticks;

use std::path::Path;

use copq::{EnvSpec, Result};

pub(crate) use canvas::encode_png;
pub use compare::{Labelled, compare, comparison_table};
use curves::{Evaluated, Quantity};
pub(crate) use font::DEJAVU_SANS;
pub(crate) use layout::colour;

use copq::files;

/// A line with a band around it.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    label: String,
    points: Vec<Point>,
}

/// One evaluation, or the same evaluation of several seeds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    step: f64,
    middle: f64,
    low: f64,
    high: f64,
}

/// One pair of axes.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    title: String,
    /// Where a dashed line goes across.
    limit: Option<f64>,
    series: Vec<Series>,
}

/// Panels that share their axes' names, their colours and one legend.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    title: String,
    /// What line and band mean, in small print under the title.
    note: String,
    panels: Vec<Panel>,
}

/// What a dashed line means.
const LIMIT_NOTE: &str = " Dashed: the limit.";

/// Draws a run's evaluations as `curve.svg` and `curve.png` in its folder, and the limits of its task's costs.
pub(crate) fn draw_run(folder: &Path, spec: &EnvSpec) -> Result<()> {
    let run = Evaluated::read(folder)?;
    let plan = crate::folder::read_plan(folder)?;
    let title =
        format!("{}, {} on {}, {} bound, seed {}", plan.method, plan.task, plan.engine, plan.bound, plan.run.seed);
    let limit = |title: &str| {
        let objective = spec.names().into_iter().position(|name| name == title)?;
        spec.limit(objective).map(f64::from)
    };
    let panel = |quantity: Quantity| Panel {
        title: quantity.title(),
        limit: limit(&quantity.title()),
        series: vec![Series { label: String::new(), points: run.over_episodes(&quantity) }],
    };
    let panels: Vec<_> = run.quantities().into_iter().map(panel).collect();
    let dashed = if panels.iter().any(|panel| panel.limit.is_some()) { LIMIT_NOTE } else { "" };
    let note = format!("Line: mean of the evaluation episodes. Band: lowest to highest episode.{dashed}");
    let figure = Figure { title, note, panels };
    files::replace(&folder.join("curve.svg"), canvas::svg(&figure)?.as_bytes())?;
    files::replace(&folder.join("curve.png"), &canvas::png(&figure)?)
}
