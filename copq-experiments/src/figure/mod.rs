//! Figures: evaluation curves of one run or of several.

mod compare;
mod curves;
mod group;

use std::path::Path;

use copq::{EnvSpec, Result};
use copq_render::{Figure, Panel, Series};

pub use compare::{compare, comparison_table};
pub(crate) use curves::{Evaluated, LAST, Quantity, common_end, quantities};

/// What a dashed line means.
const LIMIT_NOTE: &str = " Dashed: the limit.";

/// Draws a run's evaluations as `curve.svg` and `curve.png` in its folder, and the limits of its
/// task's costs.
pub(crate) fn draw_run(folder: &Path, spec: &EnvSpec) -> Result<()> {
    let run = Evaluated::read(folder)?;
    let plan = crate::folder::read_plan(folder)?;
    let bound = plan.bound.map_or(String::new(), |bound| format!(", {bound} bound"));
    let title =
        format!("{}, {} on {}{bound}, seed {}", plan.method, plan.task, plan.engine, plan.run.seed);
    let limit = |title: &str| {
        let objective = spec.names().into_iter().position(|name| name == title)?;
        spec.limit(objective).map(f64::from)
    };
    let limits: Vec<_> = run.quantities().iter().map(|quantity| limit(&quantity.title())).collect();
    let dashed = if limits.iter().any(Option::is_some) { LIMIT_NOTE } else { "" };
    let note =
        format!("Line: mean of the evaluation episodes. Band: lowest to highest episode.{dashed}");
    let mut figure = Figure::new(title, note);
    for (quantity, limit) in run.quantities().iter().zip(limits) {
        let series = Series::new("", run.over_episodes(quantity));
        figure = figure.panel(Panel::new(quantity.title()).limit(limit).series(series));
    }
    figure.write(folder.join("curve.svg"))?;
    figure.write(folder.join("curve.png"))
}
