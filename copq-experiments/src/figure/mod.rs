//! Figures: evaluation curves of one run or of several.

mod compare;
mod curves;
mod group;

use std::path::Path;

use copq::{EnvSpec, Objective, Result};

pub use compare::{compare, comparison_table};
pub(crate) use curves::{Evaluated, LAST, Line, Quantity, at_shared_steps, common_end, quantities};

use crate::report::ReportRun;

/// What a dashed line means.
pub(crate) const LIMIT_NOTE: &str = " Dashed: the limit.";

/// Draws a run's evaluations as `curve.svg` and `curve.png` in its folder, and the limits of its
/// task's costs.
pub(crate) fn draw_run(folder: &Path, spec: &EnvSpec) -> Result<()> {
    let plan = crate::folder::read_plan(folder)?;
    let bound = plan.bound.map_or(String::new(), |bound| format!(", {bound} bound"));
    let title =
        format!("{}, {} on {}{bound}, seed {}", plan.method, plan.task, plan.engine, plan.run.seed);
    let limit = |objective: &Objective| Some((objective.name.clone(), f64::from(objective.limit?)));
    let limits = spec.objectives.iter().filter_map(limit).collect();
    // A single run needs no name.
    let run = [ReportRun::new(folder).called("")];
    compare(&title, &run, &limits, &folder.join("curve.svg"))?;
    compare(&title, &run, &limits, &folder.join("curve.png"))
}
