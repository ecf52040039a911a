//! What many runs came to: one page, figures and tables.

mod curves;
mod ellipses;
mod groups;
mod page;
mod plane;
mod stored;
mod tables;

use std::path::Path;
use std::time::Duration;

use copq::{Result, files};
use copq_render::Figure;

use crate::numbers::grouped;
use groups::Groups;
pub use stored::ReportRun;
use stored::Stored;
pub use tables::{Cell, Table};

/// Many runs, read once: their tables, figures, and a page with all of it.
///
/// Runs of one task are drawn together; a method is called by what sets it apart from the others.
/// Seeds are replicates. Whatever is there is told, what cannot be read among it.
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
    references: Vec<(String, f64)>,
}

impl Report {
    /// Reads the runs; those that are not there yet are told as such.
    pub fn read(title: impl Into<String>, runs: &[ReportRun]) -> Self {
        let runs: Vec<Stored> = runs.iter().map(Stored::read).collect();
        let groups = Groups::of(&runs);
        Self { title: title.into(), runs, groups, references: Vec::new() }
    }

    /// Scores of tasks, such as a paper's, by which results are divided where tasks are taken
    /// together.
    pub fn references(self, references: Vec<(String, f64)>) -> Self {
        Self { references, ..self }
    }

    /// Whether a run is at work or waits.
    pub fn is_going_on(&self) -> bool {
        use crate::standing::Standing::{Running, Waiting};
        self.runs.iter().any(|run| matches!(run.standing, Running(_) | Waiting))
    }

    /// What there is, in a line.
    pub fn summary(&self) -> String {
        let count = |word: &str| self.runs.iter().filter(|run| run.standing.word() == word).count();
        let states: Vec<String> = ["done", "running", "stopped", "failed", "waiting"]
            .into_iter()
            .filter(|word| count(word) > 0)
            .map(|word| format!("{} {word}", count(word)))
            .collect();
        let steps: u64 = self.runs.iter().map(|run| run.steps).sum();
        let hours = self.runs.iter().map(|run| run.seconds).sum::<f64>() / 3_600.0;
        format!(
            "{} runs: {}; {} steps in {hours:.1} hours of training",
            self.runs.len(),
            states.join(", "),
            grouped(steps)
        )
    }

    /// The curves of each task, as they are on the page: a name for its file, and the figure.
    pub fn figures(&self) -> Vec<(String, Figure)> {
        let worlds = self.groups.worlds.iter();
        let mut all: Vec<_> = worlds
            .map(|world| (file_name(&world.name), self.curves(world, false).figure()))
            .collect();
        if self.groups.worlds.len() > 1 {
            all.insert(0, ("all-tasks".to_owned(), self.overview()));
        }
        all.extend(self.diagnostics().into_iter().map(|d| (file_name(&d.title), d.figure())));
        all
    }

    /// The tables: final results, best results, areas, rewards and costs, all tasks together.
    pub fn tables(&self) -> Vec<Table> {
        tables::all(self)
    }

    /// The page as HTML, by itself: no script, picture or font is anywhere else. With `every`, it
    /// loads itself again after that time.
    pub fn page(&self, every: Option<Duration>) -> Result<String> {
        page::render(self, every)
    }

    /// Writes the tables as Markdown, LaTeX and CSV, and the figures as SVG and PNG, into a folder.
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
        for (name, plane) in self.planes().into_iter().chain(self.ellipses()?) {
            plane.write(folder.join(format!("{name}.svg")))?;
        }
        for (name, figure) in self.figures() {
            for ending in ["svg", "png"] {
                figure.write(folder.join(format!("{name}.{ending}")))?;
            }
        }
        Ok(())
    }
}

/// A name of plain letters.
fn file_name(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_ascii_alphanumeric() && c != '.');
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}
