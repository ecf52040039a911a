//! All tasks together: scores divided by the tasks' references.

use copq_render::{Figure, Panel, Point, Series};

use super::Report;
use super::groups::World;
use super::paper::Measure;
use super::table::{Cell, Table};
use crate::statistics::{Bootstrap, iqm, max, mean, profile};

/// The number of steps of a profile's thresholds.
const THRESHOLDS: usize = 100;

impl Report {
    /// The tasks that have a reference score, if there are at least two.
    fn referenced(&self) -> Option<Vec<(&World, f64)>> {
        let reference = |world: &World| self.paper.reference.get(&world.task).copied();
        let worlds = self.groups.worlds.iter();
        let worlds: Vec<_> = worlds.filter_map(|world| Some((world, reference(world)?))).collect();
        (worlds.len() > 1).then_some(worlds)
    }

    /// A method's final totals divided by the references, task by task; none if it lacks one of the
    /// tasks, because it is not comparable.
    fn scores(&self, label: usize, worlds: &[(&World, f64)]) -> Option<Vec<Vec<f64>>> {
        let scores = worlds.iter().map(|&(world, reference)| {
            let finals = self.seeds(world, label).totals(Measure::Final);
            finals.into_iter().map(|value| value / reference).collect::<Vec<f64>>()
        });
        let scores: Vec<_> = scores.collect();
        scores.iter().all(|seeds| !seeds.is_empty()).then_some(scores)
    }

    /// The interquartile mean and the mean of all scores.
    pub(super) fn together(&self) -> Option<Table> {
        let worlds = self.referenced()?;
        let row = |(label, name): (usize, &String)| {
            let scores = self.scores(label, &worlds).unwrap_or_default();
            let all: Vec<f64> = scores.concat();
            let of = |statistic: fn(&[f64]) -> f64| Cell {
                mean: Some(statistic(&all)).filter(|value| value.is_finite()),
                interval: Bootstrap::default().interval(&scores, statistic),
                seeds: all.len(),
                is_violated: worlds.iter().any(|(world, _)| self.exceeds(world, label)),
                ..Cell::default()
            };
            (name.clone(), vec![of(iqm), of(mean)])
        };
        let names: Vec<_> = worlds.iter().map(|(world, _)| self.headed(world)).collect();
        Some(Table {
            name: "all-tasks",
            title: format!("{} tasks together", worlds.len()),
            note: format!(
                "Final totals over the tasks' reference scores: interquartile mean and mean \
                 [stratified bootstrap interval at 95 %] (runs); of methods that have run on all. A \
                 task weighs as much as it has runs: {}.{}",
                names.join(", "),
                self.mark()
            ),
            is_of_seeds: false,
            columns: ["interquartile mean", "mean"].map(str::to_owned).to_vec(),
            rows: self.groups.labels.iter().enumerate().map(row).collect(),
        })
    }

    /// The performance profiles: what share of a method's runs scores more than a threshold.
    pub(super) fn profiles(&self) -> Option<Figure> {
        let worlds = self.referenced()?;
        let labels = self.groups.labels.iter().enumerate();
        let all = labels.map(|(i, label)| (label, self.scores(i, &worlds).unwrap_or_default()));
        let all: Vec<_> = all.collect();
        let highest = max(&all.iter().flat_map(|(_, scores)| scores.concat()).collect::<Vec<_>>());
        // Without scores, or with none above 0, there is nothing to see.
        if highest.is_nan() || highest <= 0.0 {
            return None;
        }
        let at = |scores: &[Vec<f64>], i: usize| {
            let threshold = highest * i as f64 / THRESHOLDS as f64;
            let share = |drawn: &[f64]| profile(drawn, threshold);
            let middle = share(&scores.concat());
            let bootstrap = Bootstrap { draws: 1_000, ..Bootstrap::default() };
            let [low, high] = bootstrap.interval(scores, share).unwrap_or([middle; 2]);
            Point { step: threshold, middle, low, high }
        };
        let series = |(label, scores): (&String, Vec<Vec<f64>>)| {
            let thresholds = if scores.is_empty() { 0..0 } else { 0..THRESHOLDS + 1 };
            Series::new(label, thresholds.map(|i| at(&scores, i)).collect())
        };
        let panel = Panel::new(format!("{} tasks together", worlds.len()))
            .unit("share of the runs")
            .along("score over the reference");
        let panel = all.into_iter().map(series).fold(panel, Panel::series);
        let note = "Line: the share of runs whose final total is above so many times the task's \
                    reference score. Band: stratified bootstrap interval at 95 %.";
        Some(Figure::new("Performance profiles", note).panel(panel))
    }
}
