//! Curves of all methods on a task, for figures and for the page's script.

use copq_render::{Figure, Panel, Point, Series};
use serde::{Serialize, Serializer};

use super::Report;
use super::groups::World;
use super::stored::Stored;
use crate::figure::{Evaluated, LIMIT_NOTE, Line, Quantity, at_shared_steps, quantities};
use crate::statistics::{mean, std};

/// What line and band are.
const NOTE: &str = "Line: mean of the seeds. Band: standard deviation (of one seed: lowest to \
     highest episode).";

/// The same for training's own numbers.
const TRAINING: &str = "Line: mean of the seeds. Band: standard deviation. value_error: what critics \
     expect at an episode's start, a stochastic policy's entropy bonus with it, less what came.";

/// Some panels with all methods' curves.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Curves {
    pub title: String,
    #[serde(skip)]
    pub note: String,
    pub panels: Vec<CurvePanel>,
}

/// One quantity.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CurvePanel {
    pub title: String,
    #[serde(skip)]
    pub unit: Option<&'static str>,
    pub limit: Option<f64>,
    /// One per label, in the labels' order.
    pub curves: Vec<Curve>,
}

/// A method's curve.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Curve {
    pub label: String,
    /// How many seeds it is made from.
    pub seeds: usize,
    #[serde(serialize_with = "short")]
    pub points: Vec<Point>,
    /// Each seed's own curve, if wanted.
    #[serde(skip)]
    pub thin: Vec<Line>,
}

/// Points with as many digits as an f32 has, except for the steps: nobody reads more under a
/// pointer.
fn short<S: Serializer>(points: &[Point], serializer: S) -> Result<S::Ok, S::Error> {
    let short = |p: &Point| (p.step, p.middle as f32, p.low as f32, p.high as f32);
    serializer.collect_seq(points.iter().map(short))
}

impl Curves {
    /// Whether there is nothing to draw.
    pub(crate) fn is_empty(&self) -> bool {
        self.panels.iter().flat_map(|panel| &panel.curves).all(|curve| curve.points.is_empty())
    }

    pub(crate) fn figure(&self) -> Figure {
        let panels = self.panels.iter().map(CurvePanel::panel);
        panels.fold(Figure::new(&self.title, &self.note), Figure::panel)
    }
}

impl CurvePanel {
    fn panel(&self) -> Panel {
        let panel = Panel::new(&self.title).limit(self.limit);
        let panel = match self.unit {
            Some(unit) => panel.unit(unit),
            None => panel,
        };
        self.curves.iter().fold(panel, |panel, curve| panel.series(curve.series()))
    }
}

impl Curve {
    /// Without points that are not finite, which neither a picture nor a script can show.
    fn new(label: &str, seeds: usize, mut points: Vec<Point>, thin: Vec<Line>) -> Self {
        // As f32, which the page has.
        let is_shown = |x: f64| (x as f32).is_finite();
        points.retain(|p| [p.step, p.middle, p.low, p.high].into_iter().all(is_shown));
        Self { label: label.to_owned(), seeds, points, thin }
    }

    fn series(&self) -> Series {
        Series::new(&self.label, self.points.clone()).thin(self.thin.clone())
    }
}

impl Report {
    /// The evaluations of a task, by its methods and quantities; with a thin line per seed if
    /// wanted.
    pub(super) fn curves(&self, world: &World, with_seeds: bool) -> Curves {
        let panel = |quantity: &Quantity| CurvePanel {
            title: quantity.title(),
            unit: None,
            limit: world.limits.get(&quantity.title()).copied(),
            curves: self.of_quantity(world, quantity, with_seeds),
        };
        let dashed = if world.limits.is_empty() { "" } else { LIMIT_NOTE };
        Curves {
            title: world.name.clone(),
            note: format!("{NOTE}{dashed}"),
            panels: self.quantities(world).iter().map(panel).collect(),
        }
    }

    /// One panel per task, and one for its most important objective.
    pub(super) fn overview(&self) -> Figure {
        let all = self.groups.worlds.iter();
        let worlds: Vec<_> = all.filter(|world| !self.curves(world, false).is_empty()).collect();
        let dashed =
            if worlds.iter().all(|world| world.limits.is_empty()) { "" } else { LIMIT_NOTE };
        let mut figure = Figure::new(&self.title, format!("{NOTE}{dashed}")).columns(worlds.len());
        for row in 0..2 {
            for &world in &worlds {
                let panel = match self.curves(world, false).panels.get(row) {
                    Some(panel) => {
                        let title = format!("{}: {}", world.short, panel.title);
                        CurvePanel { title, ..panel.clone() }.panel()
                    }
                    // The panels of other tasks stay in their columns.
                    None => Panel::new(&world.short),
                };
                figure = figure.panel(panel);
            }
        }
        figure
    }

    /// The quantities that any run of a task has.
    pub(super) fn quantities(&self, world: &World) -> Vec<Quantity> {
        quantities(world.runs.iter().flatten().filter_map(|&n| self.runs[n].evaluated.as_ref()))
    }

    /// The evaluations of those runs that have come at least half as far as the longest: one that
    /// failed early would end all curves and tables there.
    pub(super) fn far_enough(&self, numbers: &[usize]) -> Vec<&Evaluated> {
        self.far(numbers).into_iter().filter_map(|run| run.evaluated.as_ref()).collect()
    }

    /// Those runs.
    fn far(&self, numbers: &[usize]) -> Vec<&Stored> {
        let runs = numbers.iter().map(|&number| &self.runs[number]);
        let end = |run: &Stored| run.evaluated.as_ref().map(Evaluated::last_step);
        let longest = runs.clone().filter_map(end).max().unwrap_or(0);
        // If no run is evaluated, as with eval-every = 0, all count.
        runs.filter(|run| end(run).map_or(longest == 0, |end| 2 * end >= longest)).collect()
    }

    /// Every run's own curve.
    fn lines(&self, numbers: &[usize], quantity: &Quantity) -> Vec<Line> {
        let seeds = numbers.iter().filter_map(|&number| self.runs[number].evaluated.as_ref());
        seeds.map(|seed| seed.means(quantity)).collect()
    }

    fn of_quantity(&self, world: &World, quantity: &Quantity, with_seeds: bool) -> Vec<Curve> {
        let labels = self.groups.labels.iter().zip(&world.runs);
        let curve = |(label, numbers): (&String, &Vec<usize>)| {
            let seeds = self.far_enough(numbers);
            let lines: Vec<Line> = seeds.iter().map(|seed| seed.means(quantity)).collect();
            let points = match seeds.as_slice() {
                [seed] => seed.over_episodes(quantity),
                _ => over_seeds(&lines),
            };
            let thin = if with_seeds && numbers.len() > 1 {
                self.lines(numbers, quantity)
            } else {
                Vec::new()
            };
            Curve::new(label, seeds.len(), points, thin)
        };
        labels.map(curve).collect()
    }

    /// Training's own numbers: what the bound does, and what holds the costs.
    pub(super) fn diagnostics(&self) -> Vec<Curves> {
        let worlds = self.groups.worlds.iter();
        worlds.map(|world| self.traces(world)).filter(|curves| !curves.panels.is_empty()).collect()
    }

    fn traces(&self, world: &World) -> Curves {
        let mut names: Vec<&String> = Vec::new();
        for run in world.runs.iter().flatten().map(|&number| &self.runs[number]) {
            for (name, _) in &run.traces {
                // Disagreements are drawn as ellipses.
                if !names.contains(&name) && !name.starts_with("q_std/") {
                    names.push(name);
                }
            }
        }
        names.sort();
        let panel = |name: &String| CurvePanel {
            title: name.clone(),
            unit: Some(unit(name)),
            limit: None,
            curves: self.of_trace(world, name),
        };
        Curves {
            title: format!("{}: in training", world.name),
            note: TRAINING.to_owned(),
            panels: names.into_iter().map(panel).collect(),
        }
    }

    fn of_trace(&self, world: &World, name: &str) -> Vec<Curve> {
        let labels = self.groups.labels.iter().zip(&world.runs);
        let curve = |(label, numbers): (&String, &Vec<usize>)| {
            let runs = self.far(numbers);
            let bin = runs.iter().map(|run| run.bin).max().unwrap_or(1);
            let lines: Vec<_> = runs.iter().filter_map(|run| run.trace(name, bin)).collect();
            Curve::new(label, lines.len(), over_seeds(&lines), Vec::new())
        };
        labels.map(curve).collect()
    }
}

/// The unit of a trace.
fn unit(name: &str) -> &'static str {
    match name.split('/').next() {
        Some("clip_rate") => "share of the targets",
        Some("critic_loss") => "squared error",
        Some("value_error") => "expected less what came, discounted",
        Some("pessimism") => "weighted value",
        Some("correlation") => "correlation",
        Some("multiplier") => "lambda",
        _ => "share",
    }
}

/// Mean and deviation at the steps that all seeds have reached.
fn over_seeds(seeds: &[Line]) -> Vec<Point> {
    let points = at_shared_steps(seeds).into_iter();
    points.map(|(step, values)| Point::within(step, mean(&values), std(&values))).collect()
}
