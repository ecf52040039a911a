//! Several runs side by side: one picture and one table, to show what a swapped part is worth.

use std::collections::BTreeMap;
use std::path::Path;

use copq::{Error, Result};
use copq_render::{Figure, Panel, Point, Series};

use super::LIMIT_NOTE;
use super::curves::{Evaluated, LAST, Line, Quantity, at_shared_steps, common_end, quantities};
use super::group::{Group, group};
use crate::numbers::grouped;
use crate::plan::Plan;
use crate::report::ReportRun;
use crate::report::table::markdown_row;
use crate::statistics::{
    Bootstrap, FEWEST, max, mean, median, min, probability_of_improvement, steps_to,
};

/// What `*` means.
const EXCEEDED: &str = "`*`: the mean cost of the last five evaluations exceeds its limit.";

/// Draws the runs' evaluation curves to `out`, whose ending decides the format: `.svg` or `.png`.
///
/// Each label has a colour. Its line is the median of its seeds, and its band goes from the lowest
/// to the highest seed; with one seed they are the mean and the range of the evaluation episodes. A
/// step that not all seeds reached is left out. A dashed line goes across at each of the `limits`,
/// and at each limit of the runs' costs that is the same for all.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let run = folder.path().join("s0");
/// # std::fs::create_dir(&run).expect("a new folder");
/// # let columns = "step,weighted_total/mean,return/speed/mean,return/speed/min,return/speed/max";
/// # let text = format!("{columns}\n0,1,20,20,20\n5000,2,30,30,30\n");
/// # copq::files::replace(&run.join("evaluations.csv"), text.as_bytes())?;
/// use copq_experiments::{ReportRun, compare};
///
/// let runs = [ReportRun::new(run).called("cholesky")];
/// let limits = [("speed".to_owned(), 20.5)].into();
/// compare("COP-Q", &runs, &limits, &folder.path().join("curve.svg"))?;
/// # Ok::<(), copq::Error>(())
/// ```
pub fn compare(
    title: &str,
    runs: &[ReportRun],
    limits: &BTreeMap<String, f64>,
    out: &Path,
) -> Result<()> {
    let groups = group(runs)?;
    let quantities = quantities(groups.iter().flat_map(|group| &group.seeds));
    let objectives: Vec<_> = quantities.iter().skip(1).map(Quantity::title).collect();
    if let Some(unknown) = limits.keys().find(|name| !objectives.contains(name)) {
        let wanted = objectives.join(" or ");
        return Err(Error::invalid("objective of a limit", wanted, unknown));
    }
    let limit = |title: &str| limits.get(title).copied().or_else(|| shared_limit(&groups, title));
    let has_limit = quantities.iter().any(|quantity| limit(&quantity.title()).is_some());
    let note = note(&groups).to_owned() + if has_limit { LIMIT_NOTE } else { "" };
    let mut figure = Figure::new(title, note);
    for quantity in &quantities {
        let panel = Panel::new(quantity.title()).limit(limit(&quantity.title()));
        figure = figure
            .panel(groups.iter().fold(panel, |panel, group| panel.series(group.series(quantity))));
    }
    figure.write(out)
}

/// A Markdown table of the same runs. First comes the mean of the last three evaluations up to the
/// last step that all of a label's seeds reached: the median over the seeds and, for several seeds,
/// their range. Then comes the mean weighted total of all evaluations until then (the area under
/// its curve): the mean over the seeds and, from three seeds on, its bootstrap interval at 95 %.
/// Last is how likely a seed has more of it than one of the first label's, up to the last step that
/// all of both reached, if both have three seeds and the same task, engine and preset.
///
/// With a threshold, a column says at which step the mean of five evaluations' weighted totals
/// first passes it, seed by seed. Notes below the table say what `*` at a label means, and which
/// seeds of a label are not evaluated at the same steps, or over as many episodes, as its first.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// use copq_experiments::{ReportRun, comparison_table};
///
/// // Two seeds of one method.
/// let runs = ["s0", "s1"].map(|seed| ReportRun::new(folder.path().join(seed)).called("cholesky"));
/// # for (run, total) in runs.iter().zip(["10", "30"]) {
/// #     std::fs::create_dir(&run.folder).expect("a new folder");
/// #     let text = format!("step,weighted_total/mean\n5000,{total}\n");
/// #     copq::files::replace(&run.folder.join("evaluations.csv"), text.as_bytes())?;
/// # }
/// let table = comparison_table(&runs, None)?;
/// assert!(table.ends_with("| cholesky | 2 | 5,000 | 20.0 (10.0 to 30.0) | 20.0 |\n"));
/// # Ok::<(), copq::Error>(())
/// ```
pub fn comparison_table(runs: &[ReportRun], passes: Option<f64>) -> Result<String> {
    let groups = group(runs)?;
    let quantities = quantities(groups.iter().flat_map(|group| &group.seeds));
    let others = groups.len() > 1;
    let head = ["label", "seeds", "steps"]
        .map(str::to_owned)
        .into_iter()
        .chain(quantities.iter().map(Quantity::title))
        .chain(["mean of the whole run".to_owned()])
        .chain(others.then(|| format!("beats {}", groups[0].label)))
        .chain(passes.map(|threshold| format!("passes {threshold} at")));
    let head: Vec<String> = head.collect();
    let mut text = markdown_row(&head);
    text += &format!("|---|--:|--:|{}\n", "--:|".repeat(head.len() - 3));
    for (i, group) in groups.iter().enumerate() {
        let beats = if i == 0 { String::new() } else { group.chance_to_beat(&groups[0]) };
        let mark = if group.exceeds_a_limit() { "*" } else { "" };
        let end = group.end();
        let first = [format!("{}{mark}", group.label), group.seeds.len().to_string(), grouped(end)];
        let cells: Vec<String> = first
            .into_iter()
            .chain(quantities.iter().map(|quantity| group.last(quantity)))
            .chain([with_interval(&group.areas(end))])
            .chain(others.then_some(beats))
            .chain(passes.map(|threshold| group.passes(threshold)))
            .collect();
        text += &markdown_row(&cells);
    }
    Ok(text + &remarks(&groups))
}

/// The limit of an objective, if it is the same in all runs that have one.
fn shared_limit(groups: &[Group], objective: &str) -> Option<f64> {
    let mut limits = groups.iter().filter_map(|group| group.limits.get(objective));
    let first = *limits.next()?;
    limits.all(|limit| *limit == first).then_some(first)
}

/// The notes below the table.
fn remarks(groups: &[Group]) -> String {
    let is_marked = groups.iter().any(Group::exceeds_a_limit);
    let mark = is_marked.then(|| EXCEEDED.to_owned());
    let all = mark.into_iter().chain(groups.iter().flat_map(Group::unlike));
    all.map(|remark| format!("\n{remark}\n")).collect()
}

/// A mean over seeds, with its interval if there are enough of them. Nothing if one seed is not a
/// number.
fn with_interval(values: &[f64]) -> String {
    let middle = mean(values);
    match Bootstrap::default().interval(&[values], mean) {
        _ if middle.is_nan() => String::new(),
        None => format!("{middle:.1}"),
        Some([low, high]) => format!("{middle:.1} [{low:.1}, {high:.1}]"),
    }
}

fn note(groups: &[Group]) -> &'static str {
    let single = |group: &Group| group.seeds.len() == 1;
    if groups.iter().all(single) {
        "Line: mean of the evaluation episodes. Band: lowest to highest episode."
    } else if groups.iter().any(single) {
        "Line: median seed (mean episode where there is one seed). Band: lowest to highest."
    } else {
        "Line: median of the seeds. Band: lowest to highest seed."
    }
}

impl Group {
    fn series(&self, quantity: &Quantity) -> Series {
        let points = match self.seeds.as_slice() {
            [seed] => seed.over_episodes(quantity),
            seeds => over_seeds(seeds, quantity),
        };
        Series::new(self.label.clone(), points)
    }

    /// How likely a seed's area is larger than one of the other's, if there are enough of both; and
    /// up to which step, if that is not the end of both.
    fn chance_to_beat(&self, other: &Self) -> String {
        let world = |group: &Self| {
            let plan = group.config.as_ref().map(|config| &config.plan);
            let of_plan = plan.map(|plan| {
                let Plan { task, engine, preset, weights, world, .. } = plan;
                ([task, engine, preset].map(String::clone), weights.clone(), world.clone())
            });
            (of_plan, group.limits.clone())
        };
        if world(self) != world(other) {
            return "another world".to_owned();
        }
        let end = common_end(self.seeds.iter().chain(&other.seeds));
        let both = [self.areas(end), other.areas(end)];
        if both.iter().any(|areas| areas.len() < FEWEST) {
            return String::new();
        }
        let chance = probability_of_improvement(&both[0], &both[1]);
        match [self.end(), other.end()] {
            _ if chance.is_nan() => String::new(),
            ends if ends == [end; 2] => format!("{chance:.2}"),
            _ => format!("{chance:.2} (to {})", grouped(end)),
        }
    }

    /// The steps at which the mean of five evaluations first passes a threshold, seed by seed.
    fn passes(&self, threshold: f64) -> String {
        let step = |seed: &Evaluated| {
            let (steps, totals) = seed.trained(&Quantity::WeightedTotal, seed.last_step());
            if totals.len() < LAST {
                return "too early".to_owned();
            }
            let step = steps_to(threshold, LAST, &steps, &totals);
            step.map_or("never".to_owned(), |step| grouped(step as u64))
        };
        self.seeds.iter().map(step).collect::<Vec<_>>().join("; ")
    }

    /// The area under each seed's weighted total up to a step.
    fn areas(&self, end: u64) -> Vec<f64> {
        self.seeds.iter().map(|seed| seed.area(end)).collect()
    }

    /// The end of the runs as a cell of the table.
    fn last(&self, quantity: &Quantity) -> String {
        let end = self.end();
        let ends: Vec<f64> =
            self.seeds.iter().map(|seed| last_three(seed, quantity, end)).collect();
        let middle = median(&ends);
        match (middle.is_nan(), ends.len()) {
            (true, _) => "".to_owned(),
            (_, 1) => format!("{middle:.1}"),
            _ => format!("{middle:.1} ({:.1} to {:.1})", min(&ends), max(&ends)),
        }
    }
}

/// The mean of the last three evaluations up to a step.
fn last_three(seed: &Evaluated, quantity: &Quantity, end: u64) -> f64 {
    let (_, values) = seed.trained(quantity, end);
    mean(&values[values.len().saturating_sub(3)..])
}

fn over_seeds(seeds: &[Evaluated], quantity: &Quantity) -> Vec<Point> {
    let lines: Vec<Line> = seeds.iter().map(|seed| seed.means(quantity)).collect();
    let point = |(step, values): (f64, Vec<f64>)| Point {
        step,
        middle: median(&values),
        low: min(&values),
        high: max(&values),
    };
    at_shared_steps(&lines).into_iter().map(point).collect()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn run(folder: &Path, name: &str, ends: [f64; 3]) -> PathBuf {
        let path = folder.join(name);
        std::fs::create_dir(&path).unwrap();
        let mut text =
            "step,weighted_total/mean,return/speed/mean,return/speed/min,return/speed/max\n"
                .to_owned();
        for (i, end) in ends.iter().enumerate() {
            text += &format!("{},{end},{},0,9\n", 1_000 * i, 2.0 * end);
        }
        std::fs::write(path.join("evaluations.csv"), text).unwrap();
        path
    }

    #[test]
    fn the_table_gives_the_median_of_the_seeds() {
        let folder = tempfile::tempdir().unwrap();
        let labelled =
            |label: &str, name, ends| ReportRun::new(run(folder.path(), name, ends)).called(label);
        let runs = [
            labelled("cholesky", "c0", [1.0, 2.0, 3.0]),
            labelled("minimum", "m0", [0.0, 0.5, 1.0]),
            labelled("cholesky", "c1", [4.0, 5.0, 6.0]),
            labelled("cholesky", "c2", [2.0, 3.0, 4.0]),
        ];
        let wanted = "\
            | label | seeds | steps | weighted total | speed | mean of the whole run | beats cholesky |\n\
            |---|--:|--:|--:|--:|--:|--:|\n\
            | cholesky | 3 | 2,000 | 3.5 (2.5 to 5.5) | 7.0 (5.0 to 11.0) | 3.3 [2.0, 5.0] |  |\n\
            | minimum | 1 | 2,000 | 0.8 | 1.5 | 0.5 |  |\n";
        assert_eq!(comparison_table(&runs, None).unwrap(), wanted);
        // A seed that stopped earlier ends the comparison there.
        let short = runs[0].folder.join("evaluations.csv");
        let text = std::fs::read_to_string(&short).unwrap();
        std::fs::write(
            &short,
            text.lines().take(3).fold(String::new(), |all, line| all + line + "\n"),
        )
        .unwrap();
        assert!(
            comparison_table(&runs, None)
                .unwrap()
                .contains("| cholesky | 3 | 1,000 | 3.0 (2.0 to 5.0) |")
        );
        // Who went on longer is compared as far as both went.
        let seeds = ["m1", "m2"].map(|name| labelled("minimum", name, [9.0, 9.0, -900.0]));
        let table = comparison_table(&[&runs[..], &seeds].concat(), None).unwrap();
        assert!(table.contains("| -145.3 [-218.2, 0.5] | 0.67 (to 1,000) |"), "{table}");
        let limit = |objective: &str, value| [(objective.to_owned(), value)].into();
        for name in ["x.svg", "x.png"] {
            compare("COP-Q", &runs, &limit("speed", 20.5), &folder.path().join(name)).unwrap();
        }
        let svg = std::fs::read_to_string(folder.path().join("x.svg")).unwrap();
        let words =
            ["COP-Q", "cholesky", "minimum", "weighted total", "speed", "Dashed: the limit.", "20"];
        assert!(words.iter().all(|text| svg.contains(text)));
        assert!(compare("COP-Q", &runs, &[].into(), Path::new("x.pdf")).is_err());
        let error = compare("COP-Q", &runs, &limit("sped", 1.0), Path::new("x.svg"))
            .unwrap_err()
            .to_string();
        assert!(["limit", "speed", "sped"].iter().all(|text| error.contains(text)), "{error}");
    }

    /// A run whose returns at these steps are these.
    fn at(folder: &Path, name: &str, rows: &[(u64, f64)]) -> ReportRun {
        let path = folder.join(name);
        std::fs::create_dir(&path).unwrap();
        let rows = rows.iter().map(|(step, x)| format!("{step},10,{x},{x}\n"));
        let text = "step,episodes,weighted_total/mean,return/cost/mean\n".to_owned();
        std::fs::write(path.join("evaluations.csv"), text + &rows.collect::<String>()).unwrap();
        ReportRun::new(path).called(name.split_once('-').unwrap().0)
    }

    /// What is over its limit is marked, and where a total is passed is said seed by seed.
    #[test]
    fn a_limit_and_a_threshold() {
        let folder = tempfile::tempdir().unwrap();
        let rising: Vec<(u64, f64)> = (0..8).map(|i| (1_000 * i, i as f64)).collect();
        let mut runs = [("a-s0", &rising[..]), ("a-s1", &rising[..]), ("b-s0", &rising[..5])]
            .map(|(name, rows)| at(folder.path(), name, rows));
        let table = |runs: &[ReportRun], passes| comparison_table(runs, passes).unwrap();
        // Of steps 1,000 to 5,000 the mean is 3, of 2,000 to 6,000 it is 4.
        let passed = table(&runs, Some(3.5));
        let ends: Vec<&str> =
            passed.lines().map(|line| line.rsplit(" | ").next().unwrap()).collect();
        assert_eq!(ends[0], "passes 3.5 at |");
        assert_eq!(ends[2..], ["6,000; 6,000 |", "too early |"]);
        assert!(table(&runs, Some(99.0)).contains("| never; never |"));
        // A seed that has come further is looked at to its own end.
        let short = at(folder.path(), "a-s2", &rising[..5]);
        let passed = table(&[&runs[..], &[short]].concat(), Some(3.5));
        assert!(passed.contains("| 6,000; 6,000; too early |"), "{passed}");
        assert!(!table(&runs, None).contains("limit"));
        for (limit, mark) in [(1.9, "*"), (5.1, "")] {
            runs.iter_mut().for_each(|run| run.limits = [("cost".to_owned(), limit)].into());
            let table = table(&runs, None);
            // The last five are 3 to 7; b has four, and the untrained policy's is not its fifth.
            let rows = [format!("| a{mark} | 2 |"), "| b | 1 |".to_owned()];
            assert!(rows.iter().all(|row| table.contains(row)), "{table}");
            assert_eq!(table.contains(EXCEEDED), limit < 5.0);
        }
        // The first seed's folder need not know its limit.
        runs[0].limits.clear();
        runs[1].limits = [("cost".to_owned(), 1.9)].into();
        assert!(table(&runs, None).contains("| a* | 2 |"));
    }

    /// Whoever is evaluated less often is not measured to another step than the others.
    #[test]
    fn methods_are_compared_up_to_one_step() {
        let folder = tempfile::tempdir().unwrap();
        // 1,000 where the others are not evaluated any more.
        let often = [(0, 0.0), (10, 1.0), (20, 2.0), (30, 3.0), (40, 1_000.0)];
        let rare = [(0, 0.0), (30, 4.0), (60, 4.0)];
        let runs: Vec<ReportRun> = [("a", &often[..]), ("b", &rare[..])]
            .into_iter()
            .flat_map(|(label, rows)| [0, 1, 2].map(|seed| (format!("{label}-s{seed}"), rows)))
            .map(|(name, rows)| at(folder.path(), &name, rows))
            .collect();
        let mut limited = runs.clone();
        limited[3..].iter_mut().for_each(|run| run.limits = [("cost".to_owned(), 9.0)].into());
        let apart = comparison_table(&limited, None).unwrap();
        assert!(apart.contains("| another world |"), "{apart}");
        let table = comparison_table(&runs, None).unwrap();
        assert!(table.contains(" | 1.00 (to 30) |\n"), "{table}");
        assert_eq!(table.lines().count(), 4);
        // Seeds of one method that are evaluated otherwise are told.
        let other = runs[3].clone().called("a");
        let table = comparison_table(&[runs[0].clone(), other], None).unwrap();
        let wanted = "\na: b-s0 is not evaluated as a-s0: 2 evaluations of 10 episodes before \
                      step 40, not 4 evaluations of 10 episodes.\n";
        assert!(table.contains("| a | 2 | 30 |") && table.ends_with(wanted), "{table}");
    }
}
