//! `copq plot`: the evaluation curves of several runs in one figure, and a table of how they ended.

use std::path::PathBuf;

use copq_experiments::{ReportRun, compare, comparison_table};

use crate::options::{not_of_a_run, note, say};
use crate::report::of_folder;

/// Draws and compares runs: one colour per label; runs with the same label are its seeds.
///
/// Example: copq plot --out results/hopper.svg cholesky=runs/a-s0 cholesky=runs/a-s1
/// minimum=runs/b-s0
#[derive(clap::Args)]
pub struct Plot {
    /// Figure to write, in the format of its extension, .svg or .png. May be given several times,
    /// or not at all: the table is printed anyway.
    #[arg(long, value_name = "FILE")]
    out: Vec<PathBuf>,

    /// Title of the figure.
    #[arg(long, default_value = "Evaluation without exploration")]
    title: String,

    /// Draw a dashed line at this return of an objective, such as cost=740.2; may be given several
    /// times. [default: the runs' own limits, where all runs that have one have the same]
    #[arg(long, value_name = "OBJECTIVE=RETURN", value_parser = limit, requires = "out")]
    limit: Vec<(String, f64)>,

    /// Also report, seed by seed, the step at which the mean weighted total of five evaluations
    /// first passes this.
    #[arg(long, value_name = "TOTAL", allow_negative_numbers = true, value_parser = finite)]
    passes: Option<f64>,

    /// Also write the printed Markdown table to this file.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,

    /// Name for the legend, and the folder of a run.
    #[arg(required = true, value_name = "LABEL=DIR", value_parser = labelled)]
    runs: Vec<ReportRun>,
}

fn labelled(text: &str) -> Result<ReportRun, String> {
    let (label, folder) =
        text.split_once('=').filter(|(label, _)| !label.is_empty()).ok_or("wanted LABEL=DIR")?;
    if !std::path::Path::new(folder).join("evaluations.csv").is_file() {
        return Err(format!(
            "wanted the folder of a run, got '{folder}', which has no evaluations.csv"
        ));
    }
    Ok(of_folder(std::path::Path::new(folder)).called(label))
}

fn limit(text: &str) -> Result<(String, f64), String> {
    let (objective, value) = text.split_once('=').ok_or("wanted OBJECTIVE=RETURN")?;
    Ok((objective.to_owned(), finite(value)?))
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("wanted a finite number, got {text}"))
}

impl Plot {
    pub fn run(mut self) -> anyhow::Result<()> {
        self.table.as_deref().map_or(Ok(()), not_of_a_run)?;
        for run in &mut self.runs {
            for (objective, value) in &self.limit {
                run.limits.entry(objective.clone()).and_modify(|limit| *limit = *value);
            }
        }
        let labels: String = self.runs.iter().filter_map(|run| run.label.as_deref()).collect();
        let limits = self.limit.iter().cloned().collect();
        let missing = copq_render::missing_letters(&format!("{}{labels}", self.title));
        for out in &self.out {
            if !missing.is_empty() && out.extension().is_some_and(|ending| ending == "png") {
                let shown = out.display();
                note(&format!("{shown} has no letters for {missing}; an .svg figure has"));
            }
            compare(&self.title, &self.runs, &limits, out)?;
        }
        let table = comparison_table(&self.runs, self.passes)?;
        say(&table)?;
        if let Some(path) = &self.table {
            let failed = |e| copq::Error::other(format!("writing '{}'", path.display()), e);
            std::fs::write(path, table).map_err(failed)?;
        }
        Ok(())
    }
}
