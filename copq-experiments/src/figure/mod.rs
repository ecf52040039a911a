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

use copq::Result;

pub(crate) use canvas::encode_png;
pub use compare::{Labelled, compare, comparison_table};
use curves::Evaluated;
pub(crate) use font::DEJAVU_SANS;
pub(crate) use layout::colour;

use crate::files;

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

/// Draws a run's evaluations as `curve.svg` and `curve.png` in its folder.
pub(crate) fn draw_run(folder: &Path) -> Result<()> {
    let run = Evaluated::read(folder)?;
    let plan = crate::folder::read_plan(folder)?;
    let title = format!(
        "{}, {} on {}, {} projection, seed {}",
        plan.method(),
        plan.task,
        plan.engine,
        plan.projection,
        plan.run.seed
    );
    let note = "Line: mean of the evaluation episodes. Band: lowest to highest episode.".to_owned();
    let panels = run.quantities().into_iter().map(|quantity| Panel {
        title: quantity.title(),
        limit: None,
        series: vec![Series { label: String::new(), points: run.over_episodes(&quantity) }],
    });
    let figure = Figure { title, note, panels: panels.collect() };
    files::replace(&folder.join("curve.svg"), canvas::svg(&figure)?.as_bytes())?;
    files::replace(&folder.join("curve.png"), &canvas::png(&figure)?)
}
