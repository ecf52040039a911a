//! A CSV file that grows one row at a time: `metrics.csv`, `evaluations.csv`, `timings.csv`.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use copq::Result;

use crate::sheet::{Sheet, encode};
use copq::files;

/// Appends rows; a name that it has not seen becomes a new column at the end.
#[derive(Debug)]
pub(crate) struct Table {
    path: PathBuf,
    columns: Vec<String>,
    file: File,
    last: Option<u64>,
    rows: u64,
}

impl Table {
    /// The file's rows whose step `keep` accepts; none if there is no file. An error if there is
    /// one and fewer than `wanted` of its rows are left, because nothing would write them again.
    /// Nothing is written yet: see [`Table::start`].
    pub(crate) fn read(path: &Path, wanted: u64, keep: impl Fn(u64) -> bool) -> Result<Sheet> {
        let mut sheet = Sheet::default();
        if path.exists() {
            sheet = Sheet::read(path)?;
            let left = sheet.steps().into_iter().filter(|&step| keep(step)).count() as u64;
            if left < wanted {
                return Err(sheet.lost_rows(path, wanted, left));
            }
            sheet.retain(keep);
        }
        sheet.widen(["step"]);
        Ok(sheet)
    }

    /// Both at once.
    #[cfg(test)]
    pub(crate) fn open(path: &Path, wanted: u64, keep: impl Fn(u64) -> bool) -> Result<Self> {
        Self::start(path, &Self::read(path, wanted, keep)?)
    }

    /// Writes the file with these rows, and opens it for more.
    pub(crate) fn start(path: &Path, sheet: &Sheet) -> Result<Self> {
        sheet.write(path)?;
        let file =
            File::options().append(true).open(path).map_err(files::failed("opening", path))?;
        let columns = sheet.columns().to_vec();
        let steps = sheet.steps();
        let last = steps.last().copied();
        Ok(Self { path: path.to_owned(), columns, file, last, rows: steps.len() as u64 })
    }

    /// Rows in the file that a longer run has as well: a last one that is not due belongs to the
    /// end.
    pub(crate) fn rows(&self, is_due: impl Fn(u64) -> bool) -> u64 {
        let is_end = self.last.is_some_and(|last| !is_due(last));
        self.rows - u64::from(is_end)
    }

    /// The step of the last row.
    pub(crate) fn last(&self) -> Option<u64> {
        self.last
    }

    /// Appends a row in one write.
    pub(crate) fn push(&mut self, step: u64, numbers: &[(String, f64)]) -> Result<()> {
        if numbers.iter().any(|(name, _)| !self.columns.contains(name)) {
            self.widen(numbers)?;
        }
        let mut cells = vec![String::new(); self.columns.len()];
        cells[0] = step.to_string();
        for (name, number) in numbers {
            if let Some(i) = self.columns.iter().position(|column| column == name) {
                cells[i] = number.to_string();
            }
        }
        self.file.write_all(&encode(&cells)?).map_err(files::failed("writing", &self.path))?;
        self.last = Some(step);
        self.rows += 1;
        Ok(())
    }

    fn widen(&mut self, numbers: &[(String, f64)]) -> Result<()> {
        let mut sheet = Sheet::read(&self.path)?;
        let left = sheet.steps().len() as u64;
        if left < self.rows {
            return Err(sheet.lost_rows(&self.path, self.rows, left));
        }
        sheet.widen(numbers.iter().map(|(name, _)| name.as_str()));
        *self = Self::start(&self.path, &sheet)?;
        Ok(())
    }

    /// Makes the rows so far survive a power failure.
    pub(crate) fn sync(&self) -> Result<()> {
        self.file.sync_data().map_err(files::failed("syncing", &self.path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(pairs: &[(&str, f64)]) -> Vec<(String, f64)> {
        pairs.iter().map(|&(name, number)| (name.to_owned(), number)).collect()
    }

    fn text(path: &Path) -> String {
        std::fs::read_to_string(path).unwrap()
    }

    #[test]
    fn new_names_become_columns_and_columns_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.csv");
        let mut table = Table::open(&path, 0, |_| true).unwrap();
        table.push(10, &numbers(&[("b", 0.1)])).unwrap();
        table.push(20, &numbers(&[("a,b", 1e-9), ("b", f64::NAN)])).unwrap();
        table.push(30, &numbers(&[("a,b", -2.0)])).unwrap();
        assert_eq!(text(&path), "step,b,\"a,b\"\n10,0.1,\n20,NaN,0.000000001\n30,,-2\n");
    }

    #[test]
    fn a_torn_tail_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.csv");
        for torn in ["30,0.", "30", "30,", "\0\0\0", "30,0.3,\n31,5\n"] {
            std::fs::write(&path, format!("step,a\n10,1\n20,2\n{torn}")).unwrap();
            Table::open(&path, 0, |_| true).unwrap().push(30, &numbers(&[("a", 3.0)])).unwrap();
            assert_eq!(text(&path), "step,a\n10,1\n20,2\n30,3\n", "{torn:?}");
        }
        std::fs::write(&path, "").unwrap();
        assert_eq!(Table::open(&path, 0, |_| true).unwrap().last(), None);
    }

    #[test]
    fn rows_that_nobody_writes_again_are_not_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.csv");
        let error = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let error = Table::open(&path, 3, |_| true).unwrap_err().to_string();
            assert_eq!(self::text(&path), text, "the file is as it was");
            error
        };
        for damaged in ["step,a\n10,1\nx,2\n30,3\n", "step,a\n10,1\n20.0,2\n30,3\n"] {
            assert!(error(damaged).starts_with("line 3 of "), "{}", error(damaged));
        }
        let semicolons = error("step;a\n10;1\n20;2\n30;3\n");
        assert!(semicolons.contains("line 2 of") && semicolons.contains("got '10;1'"));
        assert!(error("step,a\n10,1\n20,2\n").contains("wanted the 3 up to the checkpoint, got 2"));
        std::fs::write(&path, "step,a\n10,1\n20,2\n30,3\n40,").unwrap();
        assert_eq!(Table::open(&path, 3, |_| true).unwrap().rows(|step| step % 10 == 0), 3);
    }

    #[test]
    fn refused_rows_go_and_take_their_columns_with_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.csv");
        std::fs::write(&path, "step,a,late\n10,1,\n20,2,\n30,3,9\n").unwrap();
        let table = Table::open(&path, 2, |step| step <= 20).unwrap();
        assert_eq!((text(&path).as_str(), table.last()), ("step,a\n10,1\n20,2\n", Some(20)));
    }
}
