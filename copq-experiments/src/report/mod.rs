//! The results of many runs: one page, figures and tables.

mod claims;
mod claims_table;
mod curves;
mod ellipses;
mod groups;
mod page;
pub mod paper;
mod plane;
mod provenance;
mod seeds;
mod stored;
pub(crate) mod table;
mod tables;
mod together;

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use copq::{Result, files};
use copq_render::Figure;

use crate::numbers::{duration, grouped};
use groups::Groups;
use paper::{KnownTasks, Paper};
pub use stored::ReportRun;
use stored::Stored;
pub use table::{Cell, Table};

/// Many runs, read once: their tables, figures, and a page with all of it.
///
/// Runs of one task are drawn together; a method is named by what sets it apart from the others.
/// Seeds are replicates. Everything that is there is reported, including what cannot be read.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("s0");
/// use copq::Method;
/// use copq_experiments::{Plan, Report, ReportRun, RunFolder};
///
/// let method = Method::cop_td3();
/// let run = RunFolder::create(&path, &Plan::new(&method), &method.config)?;
/// # drop(run);
/// # let text = "step,weighted_total/mean\n0,1\n5000,20\n";
/// # copq::files::replace(&path.join("evaluations.csv"), text.as_bytes())?;
/// let report = Report::read("A first run", &[ReportRun::new(&path)]);
/// let page = report.page(None)?;
/// assert!(page.starts_with("<!DOCTYPE html>") && page.contains("cop-td3"));
/// let table = &report.tables()[0];
/// assert!(table.csv()?.contains("cop-td3,20"));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Report {
    title: String,
    runs: Vec<Stored>,
    groups: Groups,
    paper: Paper,
}

impl Report {
    /// Reads the runs; those that are not there yet are reported as such.
    pub fn read(title: impl Into<String>, runs: &[ReportRun]) -> Self {
        let mut runs: Vec<Stored> = runs.iter().map(Stored::read).collect();
        let groups = Groups::of(&mut runs);
        Self { title: title.into(), runs, groups, paper: Paper::default() }
    }

    /// Adds what a paper reports for these tasks and methods, beside which the runs are put; an
    /// error if the paper names others.
    pub fn paper(self, paper: Paper) -> Result<Self> {
        let mut known = KnownTasks::new();
        for world in &self.groups.worlds {
            let task = known.entry(&world.task).or_default();
            task.objectives.extend(world.weights.keys().map(String::as_str));
            task.limits.extend(world.limits.keys().map(String::as_str));
            task.methods.extend(self.groups.methods(world));
        }
        paper.check(&known)?;
        Ok(Self { paper, ..self })
    }

    /// Whether a run is in progress or waits to start. A folder without a `config.toml` does not
    /// count, unless a run is planned there.
    pub fn is_going_on(&self) -> bool {
        use crate::standing::Standing::{Running, Waiting};
        self.runs.iter().any(|run| match run.standing {
            Running(_) => true,
            Waiting => run.run.planned.is_some() || !run.run.folder.exists(),
            _ => false,
        })
    }

    /// A summary in one line.
    pub fn summary(&self) -> String {
        let count = |word: &str| self.runs.iter().filter(|run| run.standing.word() == word).count();
        let states: Vec<String> = ["done", "running", "stopped", "failed", "waiting"]
            .into_iter()
            .filter(|word| count(word) > 0)
            .map(|word| format!("{} {word}", count(word)))
            .collect();
        let steps: u64 = self.runs.iter().map(|run| run.steps).sum();
        let time = duration(self.runs.iter().map(|run| run.seconds).sum());
        let (runs, states, steps) = (self.runs.len(), states.join(", "), grouped(steps));
        let troubled = self.runs.iter().filter(|run| !run.problems.is_empty()).count();
        let troubles = match troubled {
            0 => String::new(),
            some => format!("; {some} with problems, which the page names"),
        };
        format!("{runs} runs: {states}; {steps} steps in {time} of training{troubles}")
    }

    /// The curves of each task, as on the page: a name for its file, and the figure.
    pub fn figures(&self) -> Vec<(String, Figure)> {
        let worlds = self.groups.worlds.iter();
        let mut all: Vec<_> = worlds
            .map(|world| (file_name(&world.name), self.curves(world, false).figure()))
            .collect();
        if self.groups.worlds.len() > 1 {
            all.insert(0, ("all-tasks".to_owned(), self.overview()));
        }
        all.extend(self.profiles().map(|figure| ("performance-profiles".to_owned(), figure)));
        all.extend(self.diagnostics().into_iter().map(|d| (file_name(&d.title), d.figure())));
        all
    }

    /// The tables: final results, best results, areas, rewards and costs, all tasks together.
    pub fn tables(&self) -> Vec<Table> {
        tables::all(self)
    }

    /// The page as self-contained HTML: no script, picture or font is anywhere else. With `every`,
    /// it reloads itself after that time.
    pub fn page(&self, every: Option<Duration>) -> Result<String> {
        page::render(self, every)
    }

    /// Writes the tables as Markdown, LaTeX and CSV, and the figures as SVG and PNG, into a folder;
    /// for a paper's column, there are also figures with one panel above the other
    /// (`NAME-column.svg`).
    pub fn write_parts(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder).map_err(files::failed("making", folder))?;
        for table in self.tables() {
            let write = |ending: &str, text: String| {
                files::replace(&folder.join(format!("{}.{ending}", table.name)), text.as_bytes())
            };
            write("md", table.markdown())?;
            write("tex", table.latex())?;
            write("csv", table.csv()?)?;
        }
        let judged = self.judged();
        if !judged.is_empty() {
            let text = claims_table::markdown(&judged);
            files::replace(&folder.join("claims.md"), text.as_bytes())?;
            files::replace(&folder.join("claims.csv"), &claims_table::csv(&judged)?)?;
        }
        let mut known = BTreeSet::new();
        for (name, plane) in self.planes().into_iter().chain(self.ellipses()) {
            let name = distinct(name, &mut known);
            for ending in ["svg", "png"] {
                plane.write(folder.join(format!("{name}.{ending}")))?;
            }
        }
        for (name, figure) in self.figures() {
            let name = distinct(name, &mut known);
            for ending in ["svg", "png"] {
                figure.write(folder.join(format!("{name}.{ending}")))?;
            }
            figure.columns(1).write(folder.join(format!("{name}-column.svg")))?;
        }
        Ok(())
    }
}

/// A name that is not taken yet, even on disks that take `A` for `a`: the second is `name-2`.
fn distinct(name: String, known: &mut BTreeSet<String>) -> String {
    let names = (2..).map(|number| format!("{name}-{number}"));
    let mut names = std::iter::once(name.clone()).chain(names);
    // The chain has no end.
    names.find(|name| known.insert(name.to_lowercase())).unwrap_or(name)
}

/// A name of plain letters.
fn file_name(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_ascii_alphanumeric() && c != '.');
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod claims_tests;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::config::{MadeWith, RunConfig};
    use crate::plan::Plan;

    /// A run's folder with a plan, and evaluations at steps 0, 10 and so on.
    pub(super) fn stored(
        folder: &Path,
        name: &str,
        change: impl Fn(&mut Plan),
        totals: &[f64],
    ) -> ReportRun {
        let path = folder.join(name);
        std::fs::create_dir(&path).unwrap();
        let method = copq::Method::cop_td3();
        let mut plan = Plan::new(&method);
        change(&mut plan);
        let config = RunConfig { plan, settings: method.config, made_with: MadeWith::here() };
        crate::config::write(&path.join("config.toml"), &config).unwrap();
        let rows = totals.iter().enumerate().map(|(i, total)| format!("{},{total}\n", 10 * i));
        let text = "step,weighted_total/mean\n".to_owned() + &rows.collect::<String>();
        std::fs::write(path.join("evaluations.csv"), text).unwrap();
        ReportRun::new(path)
    }

    fn seed(seed: u64) -> impl Fn(&mut Plan) {
        move |plan| plan.run.seed = seed
    }

    fn cell(report: &Report, table: usize, row: usize) -> String {
        report.tables()[table].rows[row].1[0].plain()
    }

    #[test]
    fn a_seed_counts_once_and_one_that_failed_early_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let of =
            |name: &str, number, totals: &[f64]| stored(folder.path(), name, seed(number), totals);
        let runs = [
            of("a", 0, &[9.0, 1.0, 2.0, 3.0]),
            of("b", 1, &[9.0, 1.0, 2.0, 5.0]),
            of("b-short", 1, &[9.0, 100.0]),
            of("c", 2, &[9.0]),
        ];
        let report = Report::read("x", &runs);
        // The last; the best once it trains; the best of the mean; the area.
        for (table, wanted) in
            ["4.00 ± 1.00", "4.00 ± 1.00", "4.00", "3.17 ± 0.17"].iter().enumerate()
        {
            assert_eq!(cell(&report, table, 0), format!("{wanted} (2 of 3)"));
        }
        let page = report.page(None).unwrap();
        assert!(page.contains("b-short: not counted: ") && page.contains("is the same seed"));
        // As the paper's tables mean it: each seed's best, against the best of the mean.
        let swinging = [of("d", 3, &[0.0, 8.0, 0.0]), of("e", 4, &[0.0, 0.0, 8.0])];
        let report = Report::read("x", &swinging);
        assert_eq!([1, 2].map(|table| cell(&report, table, 0)), ["8.00 ± 0.00 (2)", "4.00 (2)"]);
    }

    #[test]
    fn a_seed_that_diverged_is_not_hidden() {
        let folder = tempfile::tempdir().unwrap();
        let runs = [0, 1, 2].map(|number| {
            let last = if number == 1 { f64::NAN } else { 2.0 };
            stored(folder.path(), &number.to_string(), seed(number), &[0.0, 1.0, last])
        });
        let report = Report::read("x", &runs);
        assert_eq!(cell(&report, 0, 0), "NaN (3)");
        let of_totals = report.tables();
        let totals = of_totals.iter().take(4).map(|table| table.rows[0].1[0].plain());
        totals.for_each(|cell| assert_eq!(cell, "NaN (3)"));
        // The curve ends where it does, and the page's numbers are numbers.
        let page = report.page(None).unwrap();
        assert!(page.contains("[10.0,1.0,1.0,1.0]") && !page.contains("null]"));
    }

    #[test]
    fn tasks_and_methods_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str, change: &dyn Fn(&mut Plan)| {
            stored(folder.path(), name, change, &[0.0, 1.0])
        };
        let engine = |plan: &mut Plan| plan.engine = "mujoco".to_owned();
        let order = |plan: &mut Plan| plan.order = Some("vsc".to_owned());
        let mut old = of("x-s0", &seed(0));
        old.label = Some("old".to_owned());
        let runs = [of("a", &seed(0)), of("b", &engine), of("c", &order), old];
        let report = Report::read("x", &runs);
        let table = &report.tables()[0];
        assert_eq!(
            table.columns,
            ["a/hopper, rapier, gym-v5 at 10", "a/hopper, mujoco, gym-v5 at 10"]
        );
        let labels: Vec<&str> = table.rows.iter().map(|(label, _)| label.as_str()).collect();
        assert_eq!(labels, ["cop-td3", "cop-td3 vsc", "old"]);
        // A file for each task.
        let names: Vec<String> = report.figures().into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["all-tasks", "a-hopper-rapier-gym-v5", "a-hopper-mujoco-gym-v5"]);
    }

    #[test]
    fn a_folder_without_a_plan_waits_for_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let run = stored(folder.path(), "a", seed(0), &[0.0]);
        std::fs::remove_file(run.folder.join("config.toml")).unwrap();
        assert!(!Report::read("x", std::slice::from_ref(&run)).is_going_on());
        let to_come = ReportRun::new(folder.path().join("b"));
        assert!(Report::read("x", &[run, to_come]).is_going_on());
    }

    /// A page of many films would be too large for a browser.
    #[test]
    fn films_beyond_the_room_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let runs = ["a", "b", "c"].map(|label| {
            let run = stored(folder.path(), label, seed(0), &[0.0, 1.0]);
            std::fs::write(run.folder.join("rollout.gif"), [0; 10]).unwrap();
            ReportRun { label: Some(label.to_owned()), ..run }
        });
        let report = Report::read("x", &runs);
        let shown = |room| {
            let html = page::films(&report, room).into_string();
            (html.matches("<img ").count(), html.contains("1 more would exceed the 20 MB"))
        };
        assert_eq!([30, 29].map(shown), [(3, false), (2, true)]);
    }

    /// Signs make no file's name.
    #[test]
    fn each_figure_has_a_file_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let weights = [("a", "control=-0.5"), ("b", "control=0.5"), ("c", "Control=0.5")];
        let runs = weights.map(|(name, weights)| {
            let change = |plan: &mut Plan| plan.weights = Some(weights.to_owned());
            stored(folder.path(), name, change, &[0.0, 1.0])
        });
        let parts = folder.path().join("parts");
        Report::read("x", &runs).write_parts(&parts).unwrap();
        let name = "a-hopper-rapier-gym-v5-weights-";
        for name in
            ["control-0.5", "control-0.5-2", "Control-0.5-3"].map(|end| name.to_owned() + end)
        {
            assert!(parts.join(format!("{name}.svg")).is_file(), "{name}");
            assert!(parts.join(format!("{name}-column.svg")).is_file(), "{name}");
        }
    }

    /// A setting sets methods apart where they meet, on one task.
    #[test]
    fn what_follows_the_task_makes_no_other_method() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str, task: &str, tau: f64| {
            let run = stored(folder.path(), name, |plan| plan.task = task.to_owned(), &[0.0, 1.0]);
            let file = run.folder.join("config.toml");
            let text = std::fs::read_to_string(&file).unwrap();
            std::fs::write(file, text.replace("tau = 0.005", &format!("tau = {tau}"))).unwrap();
            run
        };
        let labels = |runs: &[ReportRun]| Report::read("x", runs).groups.labels;
        let runs = [of("a", "a/hopper", 0.01), of("b", "a/ant", 0.02)];
        assert_eq!(labels(&runs), ["cop-td3"]);
        let runs = [&runs[..], &[of("c", "a/ant", 0.03)]].concat();
        assert_eq!(labels(&runs), ["cop-td3 tau=0.01", "cop-td3 tau=0.02", "cop-td3 tau=0.03"]);
    }

    #[test]
    fn tasks_together_are_of_methods_that_ran_on_all() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str, label: &str, task: &str, end| {
            let change = |plan: &mut Plan| plan.task = task.to_owned();
            let label = Some(label.to_owned());
            ReportRun { label, ..stored(folder.path(), name, change, &[0.0, end]) }
        };
        let runs = [
            of("1", "both", "a/hopper", 50.0),
            of("2", "both", "a/ant", 150.0),
            of("3", "one", "a/hopper", 500.0),
        ];
        let reference = [("a/hopper", 100.0), ("a/ant", 100.0)].map(|(t, s)| (t.to_owned(), s));
        let paper = Paper { reference: reference.into(), ..Paper::default() };
        let report = Report::read("x", &runs).paper(paper).unwrap();
        let tables = report.tables();
        let together = tables.iter().find(|table| table.name == "all-tasks").unwrap();
        let shown: Vec<String> = together.rows.iter().map(|(_, cells)| cells[1].plain()).collect();
        assert_eq!(shown, ["1.00 (2)", ""]);
        assert!(!together.markdown().contains("Mean ± standard deviation"));
        // Half of the runs is above every score under 0.5, none above 1.5.
        let profiles = report.profiles().unwrap().svg().unwrap();
        assert!(profiles.contains("score over the reference") && profiles.contains("both"));
        assert!(Report::read("x", &runs).profiles().is_none());
    }

    /// Four seeds have a middle half; three have their mean in the other tables.
    #[test]
    fn the_middle_half_of_seeds() {
        let folder = tempfile::tempdir().unwrap();
        let runs: Vec<_> = (0..4)
            .map(|i| {
                stored(
                    folder.path(),
                    &i.to_string(),
                    seed(i),
                    &[0.0, [1.0, 2.0, 4.0, 99.0][i as usize]],
                )
            })
            .collect();
        let table = |runs: &[ReportRun]| {
            let tables = Report::read("x", runs).tables();
            tables.into_iter().find(|table| table.name == "interquartile")
        };
        assert!(table(&runs[..3]).is_none());
        let cell = table(&runs).unwrap().rows[0].1[0].plain();
        assert!(cell.starts_with("3.0") && cell.ends_with("(4)"), "{cell}");
    }

    /// Several worlds end a run beyond what was wanted.
    #[test]
    fn a_run_of_several_worlds_is_looked_at_to_its_end() {
        let folder = tempfile::tempdir().unwrap();
        let change = |plan: &mut Plan| {
            plan.run.steps = 18;
            plan.envs = 5;
        };
        let mut run = stored(folder.path(), "a", change, &[0.0, 1.0, 2.0, 3.0]);
        let plan = crate::folder::read_plan(&run.folder).unwrap();
        run.planned = Some((plan, toml::Table::new()));
        assert_eq!(Report::read("x", &[run]).runs[0].end(), Some(20));
    }

    /// What critics expect at an episode's start, less what comes.
    #[test]
    fn critics_errors_are_drawn() {
        let folder = tempfile::tempdir().unwrap();
        let run = stored(folder.path(), "a", seed(0), &[0.0]);
        let text = "step,weighted_total/mean,q_start/safety,discounted/safety,q_start/x,discounted/x\n\
                    0,0,1.5,1,1,\n5000,0,2,4,3,1\n";
        std::fs::write(run.folder.join("evaluations.csv"), text).unwrap();
        let curves = &Report::read("x", &[run]).diagnostics()[0];
        let drawn = |i: usize| {
            let points = &curves.panels[i].curves[0].points;
            (
                curves.panels[i].title.as_str(),
                points.iter().map(|p| [p.step, p.middle]).collect::<Vec<_>>(),
            )
        };
        assert_eq!(drawn(0), ("value_error/safety", vec![[0.0, 0.5], [5_000.0, -2.0]]));
        assert_eq!(drawn(1), ("value_error/x", vec![[5_000.0, 2.0]]));
    }

    /// Seeds that have come differently far share their bins.
    #[test]
    fn traces_of_seeds_of_any_length_meet() {
        let folder = tempfile::tempdir().unwrap();
        let runs = [(0, 300), (1, 200)].map(|(number, rows)| {
            let change = |plan: &mut Plan| {
                plan.run.seed = number;
                plan.run.steps = 300_000;
            };
            let run = stored(folder.path(), &number.to_string(), change, &[0.0, 1.0]);
            let rows = (1..=rows).map(|i| format!("{},{}\n", 1_000 * i, 0.5));
            let text = "step,clip_rate\n".to_owned() + &rows.collect::<String>();
            std::fs::write(run.folder.join("metrics.csv"), text).unwrap();
            run
        });
        let report = Report::read("x", &runs);
        let curves = report.diagnostics();
        let points = &curves[0].panels[0].curves[0].points;
        assert!(points.len() > 120 && points.iter().all(|point| point.middle == 0.5), "{points:?}");
        assert!(points.iter().all(|point| point.step < 201_000.0));
        // One that was wanted longer has wider bins.
        let change = |plan: &mut Plan| {
            plan.run.seed = 2;
            plan.run.steps = 450_000;
        };
        let run = stored(folder.path(), "2", change, &[0.0, 1.0]);
        let rows = (1..=200).map(|i| format!("{},{}\n", 1_000 * i, 0.5));
        let text = "step,clip_rate\n".to_owned() + &rows.collect::<String>();
        std::fs::write(run.folder.join("metrics.csv"), text).unwrap();
        let curves = Report::read("x", &[&runs[..], &[run]].concat()).diagnostics();
        let curve = &curves[0].panels[0].curves[0];
        assert_eq!((curve.seeds, curve.points.len()), (3, 89));
    }
}
