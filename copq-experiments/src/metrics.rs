//! Averages of everything that is reported during training, a row of `metrics.csv` an interval.

use std::collections::BTreeMap;
use std::path::Path;

use copq::{EnvSpec, Episode, Error, Observer, Result, State};

use crate::numbers::{Numbers, grouped, weighted_total};
use crate::table::Table;

/// An observer that averages each named scalar until [`Metrics::row`] writes the averages down.
///
/// Columns appear when their first number does, and keep their place from then on.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("metrics.csv");
/// use copq::Observer;
/// use copq_experiments::{Metrics, Sheet};
///
/// let mut metrics = Metrics::open(&path, |_| true)?; // all rows that are there are kept
/// metrics.scalar(1, "q/safety", 2.0);
/// metrics.scalar(2, "q/safety", 4.0);
/// assert_eq!(metrics.row(2)?, [("q/safety".to_owned(), 3.0)]);
/// assert_eq!(Sheet::read(&path)?.column("q/safety"), Some(vec![3.0]));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Metrics {
    table: Table,
    sums: BTreeMap<String, (f64, u64)>,
    /// A name that no column can have.
    refused: Option<String>,
    warnings: Vec<String>,
}

impl Observer for Metrics {
    fn warn(&mut self, step: u64, text: &str) {
        self.warnings.push(format!("warning at step {}: {text}", grouped(step)));
    }

    fn scalar(&mut self, _step: u64, name: &str, value: f64) {
        match self.sums.get_mut(name) {
            Some((sum, count)) => (*sum, *count) = (*sum + value, *count + 1),
            None if is_column(name) => drop(self.sums.insert(name.to_owned(), (value, 1))),
            None => self.refused = Some(name.to_owned()),
        }
    }
}

/// Whether a column can be called so: the first is `step`, and a checkpoint has a line a name.
fn is_column(name: &str) -> bool {
    !name.is_empty() && name != "step" && !name.contains(char::is_control)
}

impl Metrics {
    /// Opens or makes the file; rows whose step `keep` refuses are dropped.
    pub fn open(path: &Path, keep: impl Fn(u64) -> bool) -> Result<Self> {
        Ok(Self::of(Table::open(path, 0, keep)?))
    }

    /// The file.
    pub(crate) fn table(&self) -> &Table {
        &self.table
    }

    pub(crate) fn of(table: Table) -> Self {
        Self { table, sums: BTreeMap::new(), refused: None, warnings: Vec::new() }
    }

    /// What the learner has warned of since the last call.
    pub(crate) fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Takes in a training episode: its returns, their weighted total and its length in steps.
    pub fn episode(&mut self, step: u64, episode: &Episode, spec: &EnvSpec) {
        for (name, &value) in spec.names().into_iter().zip(&episode.returns) {
            self.scalar(step, &format!("train/return/{name}"), value);
        }
        self.scalar(
            step,
            "train/weighted_total",
            weighted_total(&episode.returns, &spec.weights()),
        );
        self.scalar(step, "train/length", episode.length as f64);
    }

    /// Writes the averages since the last row, begins new ones and returns what was written; an
    /// error if a scalar had a name that no column can have: nothing, `step`, or one with control
    /// characters.
    pub fn row(&mut self, step: u64) -> Result<Numbers> {
        if let Some(name) = self.refused.take() {
            let wanted = "a word that is not 'step', without control characters";
            return Err(Error::invalid("a scalar's name", wanted, format!("{name:?}")));
        }
        let sums = std::mem::take(&mut self.sums);
        let averages: Numbers =
            sums.into_iter().map(|(name, (sum, count))| (name, sum / count as f64)).collect();
        self.table.push(step, &averages)?;
        Ok(averages)
    }

    /// Writes the averages under way into a checkpoint.
    pub fn save(&self, state: &mut State) {
        let names: Vec<&str> = self.sums.keys().map(String::as_str).collect();
        state.put("names", names.join("\n").into_bytes());
        state.put("sums", self.sums.values().map(|&(sum, _)| sum).collect::<Vec<f64>>());
        state.put("counts", self.sums.values().map(|&(_, count)| count).collect::<Vec<u64>>());
    }

    /// Goes on with the averages that [`Metrics::save`] wrote.
    pub fn load(&mut self, state: &State) -> Result<()> {
        let names = String::from_utf8_lossy(state.get::<u8>("names")?).into_owned();
        let sums = state.get::<f64>("sums")?;
        let counts = state.get::<u64>("counts")?;
        let pairs = sums.iter().copied().zip(counts.iter().copied());
        self.sums = names.split('\n').map(str::to_owned).zip(pairs).collect();
        Ok(())
    }
}
