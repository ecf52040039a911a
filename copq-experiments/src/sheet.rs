//! A CSV of numbers in memory: how metrics are read back, cut at a checkpoint and given new
//! columns.

use std::path::Path;

use copq::{Error, Result};

use copq::files;

/// Named columns of numbers, one row per logged step. The first column is `step`; an empty cell is
/// a number that was not logged.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("metrics.csv");
/// use copq_experiments::Sheet;
///
/// // A run that crashed in the middle of its third row.
/// copq::files::replace(&path, b"step,q/safety\n1000,0.5\n2000,\n3000,0.")?;
/// let sheet = Sheet::read(&path)?;
/// assert_eq!(sheet.steps(), [1000, 2000]);
/// let q = sheet.column("q/safety").unwrap_or_default();
/// assert!(q[0] == 0.5 && q[1].is_nan());
/// assert_eq!(sheet.column("q/velocity"), None);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    columns: Vec<String>,
    // Kept as text, so that what is read and written again is the same byte for byte.
    rows: Vec<Vec<String>>,
    /// The first line that is not a row of numbers, with its number in the file.
    damaged: Option<(usize, String)>,
}

impl Sheet {
    /// Reads a file up to its first damaged row: a crash in mid-write can tear the last one.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &files::read_text(path)?)
    }

    /// The same for a text; `path` is what errors call it.
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(whole.as_bytes());
        let broken = |e: csv::Error| Error::other(format!("reading '{}'", path.display()), e);
        let columns: Vec<String> =
            reader.headers().map_err(broken)?.iter().map(str::to_owned).collect();
        let mut rows = Vec::new();
        let mut damaged = None;
        for record in reader.records() {
            let row: Vec<String> = match &record {
                Ok(record) => record.iter().map(str::to_owned).collect(),
                Err(_) => Vec::new(),
            };
            let is_number = |cell: &String| cell.is_empty() || cell.parse::<f64>().is_ok();
            let is_whole = row.len() == columns.len() && step_of(&row).is_some();
            if !is_whole || !row.iter().all(is_number) {
                let at = record.as_ref().ok().and_then(|record| record.position());
                let number = at.map_or(rows.len() + 2, |at| at.line() as usize);
                damaged = Some((number, text.lines().nth(number - 1).unwrap_or("").to_owned()));
                break;
            }
            rows.push(row);
        }
        Ok(Self { columns, rows, damaged })
    }

    /// The error for a damaged row, if there is one.
    pub(crate) fn damage(&self, path: &Path) -> Option<Error> {
        let (number, line) = self.damaged.as_ref()?;
        let start: String = line.chars().take(40).collect();
        let what = format!("line {number} of '{}'", path.display());
        Some(Error::invalid(what, self.wanted_cells(), format!("'{start}'; reading stops there")))
    }

    fn wanted_cells(&self) -> String {
        let count = self.columns.len();
        format!("{count} cells separated by commas: a whole step, then numbers or blanks")
    }

    /// The error for fewer rows than there must be; it names the line that could not be read.
    pub(crate) fn lost_rows(&self, path: &Path, wanted: u64, got: u64) -> Error {
        let advice = "repair it, or move the file away to continue without its rows";
        match &self.damaged {
            Some((number, line)) => {
                let start: String = line.chars().take(40).collect();
                Error::invalid(
                    format!("line {number} of '{}' ({advice})", path.display()),
                    self.wanted_cells(),
                    format!("'{start}'"),
                )
            }
            None => Error::invalid(
                format!("rows of '{}' ({advice})", path.display()),
                format!("the {wanted} up to the checkpoint"),
                got,
            ),
        }
    }

    /// The columns' names, `step` first.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The steps of the rows.
    pub fn steps(&self) -> Vec<u64> {
        self.rows.iter().filter_map(|row| step_of(row)).collect()
    }

    /// A column's numbers, one per row, NaN where nothing was logged; `None` if there is no such
    /// column.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|column| column == name)?;
        Some(self.rows.iter().map(|row| row[index].parse().unwrap_or(f64::NAN)).collect())
    }

    /// Drops the rows whose step is not wanted, and then the columns without any number.
    pub(crate) fn retain(&mut self, keep: impl Fn(u64) -> bool) {
        self.rows.retain(|row| step_of(row).is_some_and(&keep));
        let used: Vec<bool> = (0..self.columns.len())
            .map(|i| self.rows.iter().any(|row| !row[i].is_empty()))
            .collect();
        let strip = |cells: &mut Vec<String>| {
            let mut used = used.iter();
            cells.retain(|_| used.next() == Some(&true));
        };
        self.rows.iter_mut().for_each(strip);
        strip(&mut self.columns);
    }

    /// Adds the columns that are not there yet, empty.
    pub(crate) fn widen<'a>(&mut self, names: impl IntoIterator<Item = &'a str>) {
        for name in names {
            if !self.columns.iter().any(|column| column == name) {
                self.columns.push(name.to_owned());
                self.rows.iter_mut().for_each(|row| row.push(String::new()));
            }
        }
    }

    /// Replaces the file.
    pub(crate) fn write(&self, path: &Path) -> Result<()> {
        let mut bytes = encode(&self.columns)?;
        for row in &self.rows {
            bytes.extend(encode(row)?);
        }
        files::replace(path, &bytes)
    }
}

fn step_of(row: &[String]) -> Option<u64> {
    row.first()?.parse().ok()
}

/// One line of CSV, with its line end.
pub(crate) fn encode(cells: &[String]) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells).map_err(|e| Error::other("encoding a row of CSV", e))?;
    writer.into_inner().map_err(|e| Error::other("encoding a row of CSV", e.into_error()))
}
