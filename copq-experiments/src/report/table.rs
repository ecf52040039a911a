//! A table and its forms: Markdown, LaTeX, CSV.

use copq::{Error, Result};

use super::paper::Score;
use crate::numbers::grouped;
use crate::sheet::encode;
use crate::statistics::{Bootstrap, mean, std};

/// What a cell contains.
pub(super) const READING: &str = "\
     Mean ± standard deviation over seeds [bootstrap interval at 95 %, from three seeds on] \
     (seeds), up to the last step that all of a method's seeds have reached; (5, to 10,000) names \
     it where methods differ. (4 of 5): one has not come half as far as the others, and is left \
     out. An interval of three seeds goes from the lowest to the highest, and holds the true mean \
     only three times in four.";

/// A table of methods by tasks.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # for (seed, total) in [("s0", 10), ("s1", 30), ("s2", 20)] {
/// #     let text = format!("step,weighted_total/mean\n0,0\n5000,{total}\n");
/// #     let path = folder.path().join(seed);
/// #     std::fs::create_dir(&path).expect("a new folder");
/// #     copq::files::replace(&path.join("evaluations.csv"), text.as_bytes())?;
/// # }
/// use copq_experiments::{Cell, Report, ReportRun};
///
/// let run = |seed: &str| {
///     let label = Some("cholesky".to_owned());
///     ReportRun { label, ..ReportRun::new(folder.path().join(seed)) }
/// };
/// let report = Report::read("Three seeds", &["s0", "s1", "s2"].map(run));
/// let last = &report.tables()[0];
/// assert!(last.markdown().contains("| cholesky | 20.0 ± 8.2 [10.0, 30.0] (3) |"));
/// let cell: &Cell = &last.rows[0].1[0];
/// assert_eq!((cell.mean, cell.interval, cell.seeds), (Some(20.0), Some([10.0, 30.0]), 3));
/// assert!(last.latex().contains(r"cholesky & $20.0 \pm 8.2$ $[10.0, 30.0]$ (3) \\"));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Table {
    /// A name for its file.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// How its numbers are made.
    pub note: String,
    /// Whether its cells are means over seeds.
    pub is_of_seeds: bool,
    /// The tasks, or whatever else the columns are.
    pub columns: Vec<String>,
    /// The methods, and their cells.
    pub rows: Vec<(String, Vec<Cell>)>,
}

/// A number over seeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// The mean; nothing if there is no seed.
    pub mean: Option<f64>,
    /// The standard deviation (divided by n, as in papers), for two seeds and more.
    pub std: Option<f64>,
    /// The bootstrap interval at 95 %, for three seeds and more.
    pub interval: Option<[f64; 2]>,
    /// The seeds.
    pub seeds: usize,
    /// Runs that have begun; more than the seeds if some have not come far enough to be counted.
    pub begun: usize,
    /// The step up to which it is taken, if others in its column have a different one.
    pub to: Option<u64>,
    /// Whether a limit is exceeded.
    pub is_violated: bool,
    /// Whether it is a paper's own number, shown as it is printed there.
    pub is_published: bool,
}

impl Cell {
    /// From each seed's number.
    pub(super) fn of(values: &[f64], begun: usize) -> Self {
        Self {
            mean: Some(mean(values)).filter(|mean| mean.is_finite()),
            std: (values.len() > 1).then(|| std(values)).filter(|std| std.is_finite()),
            interval: Bootstrap::default().interval(&[values], mean),
            seeds: values.len(),
            begun,
            ..Self::default()
        }
    }

    /// A paper's number, under a limit if there is one.
    pub(super) fn published(score: Score, seeds: usize, limit: Option<f64>) -> Self {
        let is_violated = limit.is_some_and(|limit| score.mean() > limit);
        let [mean, std] = [Some(score.mean()), score.std()];
        Self { mean, std, seeds, is_violated, is_published: true, ..Self::default() }
    }

    /// As plain text.
    pub(super) fn plain(&self) -> String {
        self.text(" ± ", ["", ""])
    }

    /// With a format's signs: between mean and deviation, and around numbers.
    fn text(&self, plus_minus: &str, [open, close]: [&str; 2]) -> String {
        let begun = self.begun > self.seeds;
        let of = if begun { format!(" of {}", self.begun) } else { String::new() };
        let to = self.to.map_or(String::new(), |step| format!(", to {}", grouped(step)));
        let count = format!(" ({}{of}{to})", self.seeds);
        let Some(mean) = self.mean else {
            return if self.seeds > 0 { format!("NaN{count}") } else { String::new() };
        };
        let number = |value: f64, size| match self.is_published {
            true => value.to_string(),
            false => number(value, size),
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

/// A row of a table.
pub(crate) fn markdown_row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// With as many digits as the size of the numbers beside it deserves.
pub(super) fn number(value: f64, size: f64) -> String {
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
    /// The note, with what its cells contain.
    fn remark(&self) -> String {
        if self.is_of_seeds { format!("{} {READING}", self.note) } else { self.note.clone() }
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let head = std::iter::once("method".to_owned()).chain(self.columns.iter().cloned());
        let mut text = format!("**{}.** {}\n\n", self.title, self.remark());
        text += &markdown_row(&head.collect::<Vec<_>>());
        text += &format!("|---|{}\n", "--:|".repeat(self.columns.len()));
        for (label, cells) in &self.rows {
            let cells = cells.iter().map(Cell::plain);
            let row = std::iter::once(label.clone()).chain(cells);
            text += &markdown_row(&row.collect::<Vec<_>>());
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

    /// As CSV, every number in its own column and with all its digits. The last ones say 1 where a
    /// limit is exceeded, and give the step where methods differ in it.
    pub fn csv(&self) -> Result<String> {
        let parts = ["", " std", " low", " high", " seeds", " exceeded", " to"];
        let columns = self.columns.iter();
        let head = columns.flat_map(|column| parts.map(|part| format!("{column}{part}")));
        let mut lines = vec![std::iter::once("method".to_owned()).chain(head).collect::<Vec<_>>()];
        for (label, cells) in &self.rows {
            let numbers = cells.iter().flat_map(|cell| {
                let shown = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
                let [low, high] = [0, 1].map(|i| shown(cell.interval.map(|ends| ends[i])));
                let [seeds, exceeded] = [cell.seeds, usize::from(cell.is_violated)];
                let to = cell.to.map_or(String::new(), |step| step.to_string());
                let counts = [seeds.to_string(), exceeded.to_string(), to];
                [shown(cell.mean), shown(cell.std), low, high].into_iter().chain(counts)
            });
            lines.push(std::iter::once(label.clone()).chain(numbers).collect());
        }
        let bytes = lines.iter().map(|line| encode(line)).collect::<Result<Vec<_>>>()?.concat();
        String::from_utf8(bytes).map_err(|e| Error::other("encoding a table", e))
    }
}

/// A text with LaTeX's own characters escaped.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => escaped.extend(['\\', c]),
            '\\' => escaped += "\\textbackslash{}",
            '~' => escaped += "\\textasciitilde{}",
            '^' => escaped += "\\textasciicircum{}",
            '<' => escaped += "\\textless{}",
            '>' => escaped += "\\textgreater{}",
            '|' => escaped += "\\textbar{}",
            // First in a row, they would be an argument of the end of the row before it.
            '[' | '*' => escaped.extend(['{', c, '}']),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latex_prints_a_label_as_it_is() {
        let labels = ["[a] x<1", "*b|c", "d_e>2"];
        let table = Table {
            name: "final",
            title: "Final".to_owned(),
            note: String::new(),
            is_of_seeds: false,
            columns: vec!["t".to_owned()],
            rows: labels.map(|label| (label.to_owned(), vec![Cell::default()])).into(),
        };
        let latex = table.latex();
        let rows: Vec<&str> = latex.lines().filter(|line| line.contains(" & ")).skip(1).collect();
        let wanted =
            [r"{[}a] x\textless{}1 &  \\", r"{*}b\textbar{}c &  \\", r"d\_e\textgreater{}2 &  \\"];
        assert_eq!(rows, wanted);
    }
}
