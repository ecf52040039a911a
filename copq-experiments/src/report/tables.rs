//! The tables that papers have: which seeds, and which number of each.

use super::Report;
use super::groups::World;
use super::paper::Measure;
use super::seeds::Seeds;
use super::table::{Cell, Table};
use crate::figure::{LAST, Quantity, at_shared_steps};
use crate::numbers::grouped;
use crate::statistics::{Bootstrap, FEWEST, iqm, max, mean, probability_of_improvement};

impl Report {
    /// One column per task, headed by its name and how far the seeds have come.
    fn by_task(
        &self,
        name: &'static str,
        title: &str,
        note: &str,
        cell: impl Fn(&Seeds<'_>) -> Cell,
    ) -> Table {
        let worlds = &self.groups.worlds;
        let cell = |world: &World, label: usize| {
            let seeds = self.seeds(world, label);
            let to = self.apart(world, seeds.end).filter(|_| !seeds.is_empty());
            Cell { to, is_violated: self.exceeds(world, label), ..cell(&seeds) }
        };
        let cells = |label| worlds.iter().map(|world| cell(world, label)).collect();
        let labels = self.groups.labels.iter().enumerate();
        Table {
            name,
            title: title.to_owned(),
            note: format!("{note}{}", self.mark()),
            is_of_seeds: true,
            columns: worlds.iter().map(|world| self.headed(world)).collect(),
            rows: labels.map(|(i, label)| (label.clone(), cells(i))).collect(),
        }
    }

    /// The same for weighted totals, with the paper's numbers.
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

    /// Puts the paper's numbers after each column that has some; `of` gives the columns' tasks and
    /// quantities.
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

    /// What `*` means at a total, if a cost has a limit.
    pub(super) fn mark(&self) -> String {
        if self.groups.worlds.iter().all(|world| world.limits.is_empty()) {
            return String::new();
        }
        format!(" * means that the mean cost of the last {LAST} evaluations exceeds its limit.")
    }

    /// The step up to which a number on a task is taken, if it is not the same for all methods.
    fn apart(&self, world: &World, end: u64) -> Option<u64> {
        self.all_ends(world).iter().any(|&other| other != end).then_some(end)
    }

    /// How many steps the last few evaluations span, if they do not all span the same number.
    fn spans(&self, worlds: &[&World]) -> String {
        let labels = 0..self.groups.labels.len();
        let all = worlds.iter().flat_map(|world| labels.clone().map(|i| self.seeds(world, i)));
        let spans: Vec<u64> = all.flat_map(|seeds| seeds.spans()).collect();
        match (spans.iter().min(), spans.iter().max()) {
            (Some(least), Some(most)) if least < most => {
                format!(" They span {} to {} steps.", grouped(*least), grouped(*most))
            }
            _ => String::new(),
        }
    }

    /// A task's name and its steps.
    pub(super) fn headed(&self, world: &World) -> String {
        let ends = self.all_ends(world);
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
    tables.extend(interquartile(report));
    tables.extend(improvement(report));
    tables.extend(reward_and_cost(report));
    tables.extend(report.together());
    tables
}

/// The maximum of the mean curve, which is not any seed's own number.
fn best_of_mean(seeds: &Seeds<'_>) -> Cell {
    let mut lines = seeds.values(&Quantity::WeightedTotal, seeds.end);
    if Measure::BestOfMean.is_early(&lines) {
        return Cell::default();
    }
    lines.iter_mut().for_each(|line| line.retain(|[step, _]| *step > 0.0));
    let shared = at_shared_steps(&lines);
    // Seeds are given by their indices, as the bootstrap draws them.
    let best = |drawn: &[f64]| {
        let mean = |(_, values): &(f64, Vec<f64>)| {
            drawn.iter().map(|&s| values[s as usize]).sum::<f64>() / drawn.len() as f64
        };
        let means: Vec<f64> = shared.iter().map(mean).collect();
        // One seed that is NaN makes it NaN, as in the other tables.
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

/// The interquartile means of the final totals, if a method has enough seeds for a middle half.
fn interquartile(report: &Report) -> Option<Table> {
    let cell = |seeds: &Seeds<'_>| {
        let values = seeds.totals(Measure::Final);
        Cell {
            mean: Some(iqm(&values)).filter(|mean| mean.is_finite()),
            interval: Bootstrap::default().interval(&[&values], iqm),
            seeds: values.len(),
            begun: seeds.begun,
            ..Cell::default()
        }
    };
    let note = "The middle half of the seeds' last evaluations, a quarter (rounded down) being left \
                out at either end: interquartile mean [bootstrap interval at 95 %] (seeds).";
    let table =
        report.by_task("interquartile", "Interquartile mean of the final total", note, cell);
    let has_quarters = table.rows.iter().flat_map(|(_, cells)| cells).any(|cell| cell.seeds > 3);
    has_quarters.then_some(Table { is_of_seeds: false, ..table })
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
         have come (to that step); from three seeds of each on. 0.5 is no difference.{}",
        report.mark()
    );
    table.is_of_seeds = false;
    for (column, world) in table.columns.iter_mut().zip(&report.groups.worlds) {
        if report.exceeds(world, 0) {
            *column += &format!(", {first}*");
        }
    }
    for (label, (_, cells)) in table.rows.iter_mut().enumerate().skip(1) {
        for (cell, world) in cells.iter_mut().zip(&report.groups.worlds) {
            let [ours, theirs] = [label, 0].map(|label| report.seeds(world, label));
            if ours.len().min(theirs.len()) >= FEWEST {
                let end = ours.common_end(&theirs);
                let total = Quantity::WeightedTotal;
                let [ours, theirs] = [ours, theirs].map(|s| s.measured(Measure::Area, &total, end));
                let chance = probability_of_improvement(&ours, &theirs);
                let mean = Some(chance).filter(|chance| chance.is_finite());
                let to = report.apart(world, end);
                *cell = Cell { mean, seeds: ours.len(), to, ..*cell };
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
        let seeds = report.seeds(world, label);
        let to = report.apart(world, seeds.end).filter(|_| !seeds.is_empty());
        Cell { is_violated, to, ..seeds.cell(&ends) }
    };
    let row = |(label, name): (usize, &String)| {
        let cells = columns.iter().map(|(world, quantity, _)| cell(label, world, quantity));
        (name.clone(), cells.collect())
    };
    let table = Table {
        name: "reward-and-cost",
        title: "Rewards and costs".to_owned(),
        note: format!(
            "Returns of the last {LAST} evaluations (Table E.3).{} * means that the mean cost \
             exceeds its limit.",
            report.spans(&worlds)
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
