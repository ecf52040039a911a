//! The tables that papers have: which seeds, and which number of each.

use super::Report;
use super::curves::over_seeds;
use super::groups::World;
use super::paper::{LAST, Measure};
use super::table::{Cell, Table};
use crate::figure::{Evaluated, Quantity};
use crate::numbers::grouped;
use crate::standing::Standing;
use crate::statistics::{Bootstrap, FEWEST, iqm, max, mean, probability_of_improvement};

/// The seeds of a method on a task.
pub(super) struct Seeds<'a> {
    seeds: Vec<&'a Evaluated>,
    /// The last step that all have reached.
    end: u64,
    /// Runs that have begun, and all.
    begun: usize,
}

impl Seeds<'_> {
    /// The values of a quantity up to a step, a list a seed.
    pub(super) fn values(&self, quantity: &Quantity, end: u64) -> Vec<Vec<(u64, f64)>> {
        let until = |seed: &&Evaluated| {
            let means = seed.means(quantity).into_iter();
            means.filter(|(step, _)| *step <= end).collect()
        };
        self.seeds.iter().map(until).collect()
    }

    /// Of each seed's number.
    fn cell(&self, values: &[f64]) -> Cell {
        Cell::of(values, self.begun)
    }

    /// A number a seed, of its weighted totals up to a step; none where a seed has fewer
    /// evaluations than it takes.
    fn measured(&self, measure: Measure, end: u64) -> Vec<f64> {
        let curves = self.values(&Quantity::WeightedTotal, end);
        if measure.is_early(&curves) {
            return Vec::new();
        }
        curves.iter().map(|curve| measure.of(curve, None)).collect()
    }

    /// The same up to the end.
    fn totals(&self, measure: Measure) -> Vec<f64> {
        self.measured(measure, self.end)
    }

    pub(super) fn end(&self) -> u64 {
        self.end
    }

    pub(super) fn is_empty(&self) -> bool {
        self.seeds.is_empty()
    }
}

impl Report {
    pub(super) fn seeds(&self, world: &World, label: usize) -> Seeds<'_> {
        let numbers = &world.runs[label];
        let begun = numbers.iter().filter(|&&n| self.runs[n].standing != Standing::Waiting);
        let seeds = self.far_enough(numbers);
        let end = seeds.iter().map(|seed| seed.last_step()).min().unwrap_or(0);
        Seeds { seeds, end, begun: begun.count() }
    }

    /// A column a task, each headed by its name and how far the seeds have come.
    fn by_task(
        &self,
        name: &'static str,
        title: &str,
        note: &str,
        cell: impl Fn(&Seeds<'_>) -> Cell,
    ) -> Table {
        let worlds = &self.groups.worlds;
        let cells = |label| worlds.iter().map(|world| cell(&self.seeds(world, label))).collect();
        let labels = self.groups.labels.iter().enumerate();
        Table {
            name,
            title: title.to_owned(),
            note: note.to_owned(),
            is_of_seeds: true,
            columns: worlds.iter().map(|world| self.headed(world)).collect(),
            rows: labels.map(|(i, label)| (label.clone(), cells(i))).collect(),
        }
    }

    /// The same of weighted totals, with the paper's numbers.
    fn of_totals(
        &self,
        measure: Measure,
        title: &str,
        note: &str,
        cell: impl Fn(&Seeds<'_>) -> Cell,
    ) -> Option<Table> {
        let table = self.by_task(measure.table()?, title, note, cell);
        let of: Vec<_> = self.groups.worlds.iter().map(|world| (world, None)).collect();
        Some(self.with_published(table, measure, &of))
    }

    /// Puts the paper's numbers behind each column that has some, the columns being of these tasks
    /// and quantities.
    fn with_published(
        &self,
        mut table: Table,
        measure: Measure,
        of: &[(&World, Option<String>)],
    ) -> Table {
        for (at, (world, quantity)) in of.iter().enumerate().rev() {
            let quantity = quantity.as_deref();
            let Some(column) = self.paper.column(measure, &world.task, quantity) else {
                continue;
            };
            let limit = quantity.and_then(|quantity| world.limits.get(quantity)).copied();
            table.rows.iter_mut().for_each(|(_, cells)| cells.insert(at + 1, Cell::default()));
            for (method, &score) in &column.scores {
                let cell = Cell::published(score, column.seeds, limit);
                if let Some(label) = self.groups.method(world, method) {
                    table.rows[label].1[at + 1] = cell;
                }
            }
            let what = quantity.map_or(String::new(), |quantity| format!(", {quantity}"));
            table.columns.insert(at + 1, format!("{}{what}: {}", world.short, column.source));
        }
        table
    }

    /// A task's name and its steps.
    fn headed(&self, world: &World) -> String {
        let ends = (0..self.groups.labels.len()).map(|label| self.seeds(world, label));
        let mut ends: Vec<u64> = ends.filter(|s| !s.seeds.is_empty()).map(|s| s.end).collect();
        ends.sort_unstable();
        let steps = match (ends.first(), ends.last()) {
            (Some(first), Some(last)) if first == last => format!(" at {}", grouped(*last)),
            (Some(first), Some(last)) => format!(" at {} to {}", grouped(*first), grouped(*last)),
            _ => String::new(),
        };
        format!("{}{steps}", world.short)
    }
}

pub(super) fn all(report: &Report) -> Vec<Table> {
    let each = |measure| move |seeds: &Seeds<'_>| seeds.cell(&seeds.totals(measure));
    let tables = [
        report.of_totals(
            Measure::Final,
            "Total return of the final policy",
            "The last evaluation's weighted total (the paper's Table 2).",
            each(Measure::Final),
        ),
        report.of_totals(
            Measure::Best,
            "Best total return in each training",
            "The best evaluation of each seed once it trains (Table E.1); it favours curves that swing.",
            each(Measure::Best),
        ),
        report.of_totals(
            Measure::BestOfMean,
            "Best of the mean curve",
            "The highest point of the seeds' mean curve once they train (Table E.2); the interval is of \
             seeds drawn anew.",
            best_of_mean,
        ),
        report.of_totals(
            Measure::Area,
            "Area under the curve",
            "The area under the weighted total's curve over its length: the mean of the whole run.",
            each(Measure::Area),
        ),
    ];
    let mut tables: Vec<Table> = tables.into_iter().flatten().collect();
    tables.extend(improvement(report));
    tables.extend(reward_and_cost(report));
    tables.extend(over_tasks(report));
    tables
}

/// The maximum of the mean curve, which is no seed's own number.
fn best_of_mean(seeds: &Seeds<'_>) -> Cell {
    let curves = seeds.values(&Quantity::WeightedTotal, seeds.end);
    if Measure::BestOfMean.is_early(&curves) {
        return Cell::default();
    }
    let lines: Vec<Vec<[f64; 2]>> = curves
        .into_iter()
        .map(|seed| seed.into_iter().skip(1).map(|(step, value)| [step as f64, value]).collect())
        .collect();
    // At the steps that all seeds have, a list of them a seed.
    let shared: Vec<f64> = over_seeds(&lines).into_iter().map(|[step, ..]| step).collect();
    let is_shared = |step: &f64| shared.binary_search_by(|s| s.total_cmp(step)).is_ok();
    let values: Vec<Vec<f64>> = lines
        .iter()
        .map(|line| line.iter().filter(|at| is_shared(&at[0])).map(|at| at[1]).collect())
        .collect();
    // Of seeds by their numbers, as the bootstrap draws them.
    let best = |drawn: &[f64]| {
        let mean =
            |i| drawn.iter().map(|&s| values[s as usize][i]).sum::<f64>() / drawn.len() as f64;
        let means: Vec<f64> = (0..shared.len()).map(mean).collect();
        // One seed that is no number makes it none, as in the other tables.
        if means.iter().any(|mean| mean.is_nan()) { f64::NAN } else { max(&means) }
    };
    let numbers: Vec<f64> = (0..lines.len()).map(|i| i as f64).collect();
    let bootstrap = Bootstrap { draws: 2_000, ..Bootstrap::default() };
    Cell {
        mean: Some(best(&numbers)).filter(|best| best.is_finite()),
        interval: bootstrap.interval(&[&numbers[..]], best),
        seeds: lines.len(),
        begun: seeds.begun,
        ..Cell::default()
    }
}

/// How likely each method is better than the first, on each task.
fn improvement(report: &Report) -> Option<Table> {
    let first = report.groups.labels.first()?;
    if report.groups.labels.len() < 2 {
        return None;
    }
    let mut table = report.by_task("improvement", "", "", |_| Cell::default());
    table.title = format!("Probability of improvement over {first}");
    table.note = format!(
        "How likely a seed's mean of the whole run is larger than one of {first}'s, as far as both \
         have come; from three seeds of each on. 0.5 is no difference."
    );
    table.is_of_seeds = false;
    for (label, (_, cells)) in table.rows.iter_mut().enumerate().skip(1) {
        for (cell, world) in cells.iter_mut().zip(&report.groups.worlds) {
            let [ours, theirs] = [label, 0].map(|label| report.seeds(world, label));
            let end = ours.end.min(theirs.end);
            if ours.seeds.len().min(theirs.seeds.len()) >= FEWEST {
                let [ours, theirs] = [ours, theirs].map(|s| s.measured(Measure::Area, end));
                let chance = probability_of_improvement(&ours, &theirs);
                let mean = Some(chance).filter(|chance| chance.is_finite());
                *cell = Cell { mean, seeds: ours.len(), ..Cell::default() };
            }
        }
    }
    table.rows.remove(0);
    table
        .rows
        .iter()
        .any(|(_, cells)| cells.iter().any(|cell| cell.mean.is_some()))
        .then_some(table)
}

/// Reward and cost of the tasks that limit a cost.
fn reward_and_cost(report: &Report) -> Option<Table> {
    let worlds: Vec<&World> =
        report.groups.worlds.iter().filter(|world| !world.limits.is_empty()).collect();
    let mut columns = Vec::new();
    for world in &worlds {
        for quantity in report.quantities(world).iter().skip(1) {
            let limit = world.limits.get(&quantity.title());
            let limit = limit.map_or(String::new(), |limit| format!(" (limit {limit:.1})"));
            columns.push((*world, quantity.clone(), format!("{}{limit}", quantity.title())));
        }
    }
    if columns.is_empty() {
        return None;
    }
    let cell = |label: usize, world: &World, quantity: &Quantity| {
        let ends = report.ends(world, label, quantity);
        let limit = world.limits.get(&quantity.title());
        let is_violated = limit.is_some_and(|&limit| mean(&ends) > limit);
        Cell { is_violated, ..report.seeds(world, label).cell(&ends) }
    };
    let row = |(label, name): (usize, &String)| {
        let cells = columns.iter().map(|(world, quantity, _)| cell(label, world, quantity));
        (name.clone(), cells.collect())
    };
    let table = Table {
        name: "reward-and-cost",
        title: "Rewards and costs".to_owned(),
        note: format!(
            "Returns of the last {LAST} evaluations (Table E.3); * means that the mean cost exceeds \
             its limit."
        ),
        is_of_seeds: true,
        columns: columns
            .iter()
            .map(|(world, _, title)| format!("{}: {title}", report.headed(world)))
            .collect(),
        rows: report.groups.labels.iter().enumerate().map(row).collect(),
    };
    let of: Vec<_> =
        columns.iter().map(|(world, quantity, _)| (*world, Some(quantity.title()))).collect();
    Some(report.with_published(table, Measure::LastFive, &of))
}

/// All tasks together, each divided by its reference.
fn over_tasks(report: &Report) -> Option<Table> {
    let reference = |world: &World| report.paper.reference.get(&world.task).copied();
    let worlds: Vec<(&World, f64)> =
        report.groups.worlds.iter().filter_map(|world| Some((world, reference(world)?))).collect();
    if worlds.len() < 2 {
        return None;
    }
    let row = |(label, name): (usize, &String)| {
        let scores = worlds.iter().map(|&(world, score)| {
            let finals = report.seeds(world, label).totals(Measure::Final);
            finals.into_iter().map(|value| value / score).collect::<Vec<f64>>()
        });
        let scores: Vec<Vec<f64>> = scores.collect();
        let all: Vec<f64> = scores.concat();
        // A method without one of the tasks is not comparable.
        let is_complete = scores.iter().all(|seeds| !seeds.is_empty());
        let of = |statistic: fn(&[f64]) -> f64| Cell {
            mean: Some(statistic(&all)).filter(|value| value.is_finite() && is_complete),
            interval: Bootstrap::default().interval(&scores, statistic).filter(|_| is_complete),
            seeds: if is_complete { all.len() } else { 0 },
            ..Cell::default()
        };
        (name.clone(), vec![of(iqm), of(mean)])
    };
    Some(Table {
        name: "all-tasks",
        title: format!("{} tasks together", worlds.len()),
        note: format!(
            "Final totals over the tasks' reference scores: interquartile mean and mean [stratified \
             bootstrap interval at 95 %] (runs); of methods that have run on all. A task weighs as \
             much as it has runs: {}.",
            worlds.iter().map(|(world, _)| report.headed(world)).collect::<Vec<_>>().join(", ")
        ),
        is_of_seeds: false,
        columns: ["interquartile mean", "mean"].map(str::to_owned).to_vec(),
        rows: report.groups.labels.iter().enumerate().map(row).collect(),
    })
}
