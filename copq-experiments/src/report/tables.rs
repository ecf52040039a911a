//! The tables that papers have, with intervals.

use copq::{Error, Result};

use super::Report;
use super::curves::over_seeds;
use super::groups::World;
use crate::figure::{Evaluated, Quantity};
use crate::numbers::grouped;
use crate::sheet::encode;
use crate::standing::Standing;
use crate::statistics::{
    Bootstrap, FEWEST, area_under, iqm, max, mean, probability_of_improvement, std,
};

/// Evaluations that a reward and its cost are the mean of.
const LAST: usize = 5;

/// A table of methods by tasks.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # for (seed, total) in [("s0", 10), ("s1", 30), ("s2", 20)] {
/// #     let text = format!("step,weighted_total/mean\n5000,{total}\n");
/// #     let path = folder.path().join(seed);
/// #     std::fs::create_dir(&path).expect("a new folder");
/// #     copq::files::replace(&path.join("evaluations.csv"), text.as_bytes())?;
/// # }
/// use copq_experiments::{Report, ReportRun};
///
/// let run = |seed: &str| {
///     let label = Some("cholesky".to_owned());
///     ReportRun { label, ..ReportRun::new(folder.path().join(seed)) }
/// };
/// let report = Report::read("Three seeds", &["s0", "s1", "s2"].map(run));
/// let last = &report.tables()[0];
/// assert!(last.markdown().contains("| cholesky | 20.0 ± 8.2 [10.0, 30.0] (3) |"));
/// assert!(last.latex().contains(r"cholesky & $20.0 \pm 8.2$ $[10.0, 30.0]$ (3) \\"));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Table {
    /// For a file.
    pub name: &'static str,
    /// What it is.
    pub title: String,
    /// How its numbers are made.
    pub note: String,
    /// Whether its cells are means over seeds.
    pub is_of_seeds: bool,
    /// The tasks, or what else is across.
    pub columns: Vec<String>,
    /// The methods, and their cells.
    pub rows: Vec<(String, Vec<Cell>)>,
}

/// A number over seeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// The mean; nothing if there is no seed.
    pub mean: Option<f64>,
    /// The standard deviation (divided by n, as papers have it), for two seeds and more.
    pub std: Option<f64>,
    /// The bootstrap interval at 95 %, for three seeds and more.
    pub interval: Option<[f64; 2]>,
    /// The seeds.
    pub seeds: usize,
    /// Runs that have begun; more than the seeds if some have not come far enough to be counted.
    pub begun: usize,
    /// Whether a limit is exceeded.
    pub is_violated: bool,
}

impl Cell {
    /// Of each seed's number.
    fn of(values: &[f64], begun: usize) -> Self {
        let interval = Bootstrap::default().interval(&[values], mean);
        Self {
            mean: Some(mean(values)).filter(|mean| mean.is_finite()),
            std: (values.len() > 1).then(|| std(values)).filter(|std| std.is_finite()),
            interval: interval.filter(|ends| ends.iter().all(|end| end.is_finite())),
            seeds: values.len(),
            begun,
            is_violated: false,
        }
    }

    /// In plain letters.
    pub(super) fn plain(&self) -> String {
        self.text(" ± ", ["", ""])
    }

    /// With signs of a form: between mean and deviation, around an interval.
    fn text(&self, plus_minus: &str, [open, close]: [&str; 2]) -> String {
        let count = if self.begun > self.seeds {
            format!(" ({} of {})", self.seeds, self.begun)
        } else {
            format!(" ({})", self.seeds)
        };
        let Some(mean) = self.mean else {
            return if self.seeds > 0 { format!("NaN{count}") } else { String::new() };
        };
        let size = self.interval.map_or(mean.abs(), |[low, high]| low.abs().max(high.abs()));
        let mark = if self.is_violated { "*" } else { "" };
        let mut text = format!("{open}{}{mark}", number(mean, size));
        if let Some(std) = self.std {
            text += &format!("{plus_minus}{}", number(std, size));
        }
        text += close;
        if let Some([low, high]) = self.interval {
            text += &format!(" {open}[{}, {}]{close}", number(low, size), number(high, size));
        }
        text + &count
    }
}

/// As many digits as the size of the numbers beside it is worth.
fn number(value: f64, size: f64) -> String {
    let digits = match size {
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        _ => 3,
    };
    let text = format!("{value:.digits$}");
    if text.trim_start_matches(['-', '0', '.']).is_empty() { text.replace('-', "") } else { text }
}

impl Table {
    /// The note, with what stands in its cells.
    fn remark(&self) -> String {
        if self.is_of_seeds { format!("{} {READING}", self.note) } else { self.note.clone() }
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let row = |cells: Vec<String>| {
            let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let head = std::iter::once("method".to_owned()).chain(self.columns.iter().cloned());
        let mut text = format!("**{}.** {}\n\n", self.title, self.remark());
        text += &row(head.collect());
        text += &format!("|---|{}\n", "--:|".repeat(self.columns.len()));
        for (label, cells) in &self.rows {
            let cells = cells.iter().map(Cell::plain);
            text += &row(std::iter::once(label.clone()).chain(cells).collect());
        }
        text
    }

    /// As LaTeX, a `tabular` for a paper's own `table`; with booktabs' rules.
    pub fn latex(&self) -> String {
        let head = std::iter::once("method").chain(self.columns.iter().map(String::as_str));
        let head: Vec<String> = head.map(escaped).collect();
        let mut text = format!("% {}. {}\n", self.title, self.remark());
        text += &format!("\\begin{{tabular}}{{l{}}}\n\\toprule\n", "r".repeat(self.columns.len()));
        text += &format!("{} \\\\\n\\midrule\n", head.join(" & "));
        for (label, cells) in &self.rows {
            let cells = cells.iter().map(|cell| cell.text(" \\pm ", ["$", "$"]));
            let row: Vec<String> = std::iter::once(escaped(label)).chain(cells).collect();
            text += &format!("{} \\\\\n", row.join(" & "));
        }
        text + "\\bottomrule\n\\end{tabular}\n"
    }

    /// As CSV, every number in a column of its own and with all its digits; the last says 1 where a
    /// limit is exceeded.
    pub fn csv(&self) -> Result<String> {
        let parts = ["", " std", " low", " high", " seeds", " exceeded"];
        let columns = self.columns.iter();
        let head = columns.flat_map(|column| parts.map(|part| format!("{column}{part}")));
        let mut lines = vec![std::iter::once("method".to_owned()).chain(head).collect::<Vec<_>>()];
        for (label, cells) in &self.rows {
            let numbers = cells.iter().flat_map(|cell| {
                let shown = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
                let [low, high] = [0, 1].map(|i| shown(cell.interval.map(|ends| ends[i])));
                let [seeds, exceeded] = [cell.seeds, usize::from(cell.is_violated)];
                let counts = [seeds.to_string(), exceeded.to_string()];
                [shown(cell.mean), shown(cell.std), low, high].into_iter().chain(counts)
            });
            lines.push(std::iter::once(label.clone()).chain(numbers).collect());
        }
        let bytes = lines.iter().map(|line| encode(line)).collect::<Result<Vec<_>>>()?.concat();
        String::from_utf8(bytes).map_err(|e| Error::other("encoding a table", e))
    }
}

/// A text without what LaTeX takes for its own.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', c]),
            '\\' => escaped += "\\textbackslash{}",
            '~' => escaped += "\\textasciitilde{}",
            '^' => escaped += "\\textasciicircum{}",
            c => escaped.push(c),
        }
    }
    escaped
}

/// The seeds of a method on a task.
pub(super) struct Seeds<'a> {
    seeds: Vec<&'a Evaluated>,
    /// The last step that all have reached.
    end: u64,
    /// Runs that have begun.
    begun: usize,
}

impl Seeds<'_> {
    /// The values of a quantity up to the end, a list a seed.
    pub(super) fn values(&self, quantity: &Quantity) -> Vec<Vec<(u64, f64)>> {
        let until = |seed: &&Evaluated| {
            let means = seed.means(quantity).into_iter();
            means.filter(|(step, _)| *step <= self.end).collect()
        };
        self.seeds.iter().map(until).collect()
    }

    /// Of each seed's number.
    fn cell(&self, values: &[f64]) -> Cell {
        Cell::of(values, self.begun)
    }

    /// A number a seed, of its weighted totals up to the end.
    fn totals(&self, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let values = self.values(&Quantity::WeightedTotal).into_iter();
        let values = values.map(|seed| seed.into_iter().map(|(_, value)| value).collect());
        values.map(|seed: Vec<f64>| of(&seed)).collect()
    }

    /// The area under each seed's weighted totals, over the steps.
    fn areas(&self, end: u64) -> Vec<f64> {
        let values = self.values(&Quantity::WeightedTotal).into_iter();
        let area = |seed: Vec<(u64, f64)>| {
            let seed = seed.into_iter().filter(|(step, _)| *step <= end);
            let (steps, values): (Vec<f64>, Vec<f64>) = seed.map(|(s, v)| (s as f64, v)).unzip();
            area_under(&steps, &values)
        };
        values.map(area).collect()
    }
}

/// The last value.
fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(f64::NAN)
}

/// The mean of the last few values.
pub(super) fn last_few(values: &[f64]) -> f64 {
    mean(&values[values.len().saturating_sub(LAST)..])
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

/// What stands in a cell.
pub(super) const READING: &str = "Mean ± standard deviation over seeds [bootstrap interval at 95 %, \
     from three seeds on] (seeds), up to the last step that all of a method's seeds have reached. (4 \
     of 5): one has not come half as far as the others, and is left out. An interval of three seeds \
     goes from the lowest to the highest, and holds the true mean only three times in four.";

pub(super) fn all(report: &Report) -> Vec<Table> {
    let mut tables = vec![
        report.by_task(
            "final",
            "Total return of the final policy",
            "The last evaluation's weighted total (the paper's Table 2).",
            |seeds| seeds.cell(&seeds.totals(last)),
        ),
        report.by_task(
            "best",
            "Best total return in each training",
            "The best evaluation of each seed once it trains (Table E.1); it favours curves that swing.",
            |seeds| seeds.cell(&seeds.totals(|values| max(values.get(1..).unwrap_or_default()))),
        ),
        report.by_task(
            "best-of-mean",
            "Best of the mean curve",
            "The highest point of the seeds' mean curve once they train (Table E.2); the interval is of \
             seeds drawn anew.",
            best_of_mean,
        ),
        report.by_task(
            "area",
            "Area under the curve",
            "The area under the weighted total's curve over its length: the mean of the whole run.",
            |seeds| seeds.cell(&seeds.areas(seeds.end)),
        ),
    ];
    tables.extend(improvement(report));
    tables.extend(reward_and_cost(report));
    tables.extend(over_tasks(report));
    tables
}

/// The maximum of the mean curve, which is no seed's own number.
fn best_of_mean(seeds: &Seeds<'_>) -> Cell {
    let lines: Vec<Vec<[f64; 2]>> = seeds
        .values(&Quantity::WeightedTotal)
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
        (0..shared.len()).map(mean).fold(f64::NAN, f64::max)
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
                let chance = probability_of_improvement(&ours.areas(end), &theirs.areas(end));
                let mean = Some(chance).filter(|chance| chance.is_finite());
                *cell = Cell { mean, seeds: ours.seeds.len(), ..Cell::default() };
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
    Some(Table {
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
    })
}

/// All tasks together, each divided by its reference.
fn over_tasks(report: &Report) -> Option<Table> {
    let reference = |world: &World| {
        let known = report.references.iter().find(|(task, _)| *task == world.task);
        known.map(|&(_, score)| score)
    };
    let worlds: Vec<(&World, f64)> =
        report.groups.worlds.iter().filter_map(|world| Some((world, reference(world)?))).collect();
    if worlds.len() < 2 {
        return None;
    }
    let row = |(label, name): (usize, &String)| {
        let scores = worlds.iter().map(|&(world, score)| {
            let finals = report.seeds(world, label).totals(last);
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
        note: "Final totals over the tasks' reference scores: interquartile mean and mean [stratified \
               bootstrap interval at 95 %] (runs); of methods that have run on all. A task weighs as \
               much as it has runs."
            .to_owned(),
        is_of_seeds: false,
        columns: ["interquartile mean", "mean"].map(str::to_owned).to_vec(),
        rows: report.groups.labels.iter().enumerate().map(row).collect(),
    })
}
