//! Averages of everything that is reported during training, one row of `metrics.csv` per interval.

use std::collections::BTreeMap;

use copq::{EnvSpec, Episode, Error, Observer, Result, State};

use crate::numbers::{Numbers, grouped, weighted_total};
use crate::table::Table;

/// An observer that averages each named scalar until [`Metrics::row`] writes the averages down.
///
/// Columns appear when their first number does, and keep their place from then on.
#[derive(Debug)]
pub(crate) struct Metrics {
    pub table: Table,
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

/// Whether a column can have this name: the first is `step`, and a checkpoint has one line per
/// name.
fn is_column(name: &str) -> bool {
    !name.is_empty() && name != "step" && !name.contains(char::is_control)
}

impl Metrics {
    pub(crate) fn of(table: Table) -> Self {
        Self { table, sums: BTreeMap::new(), refused: None, warnings: Vec::new() }
    }

    /// The learner's warnings since the last call.
    pub(crate) fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Adds a training episode: its returns, their weighted total and its length in steps.
    pub(crate) fn episode(&mut self, step: u64, episode: &Episode, spec: &EnvSpec) {
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

    /// Writes the averages since the last row, begins new ones and returns what was written. An
    /// error if a scalar had a name that no column can have: an empty one, `step`, or one with
    /// control characters.
    pub(crate) fn row(&mut self, step: u64) -> Result<Numbers> {
        if let Some(name) = self.refused.take() {
            let wanted = "a text other than '' and 'step', without control characters";
            return Err(Error::invalid("a scalar's name", wanted, format!("{name:?}")));
        }
        let sums = std::mem::take(&mut self.sums);
        let averages: Numbers =
            sums.into_iter().map(|(name, (sum, count))| (name, sum / count as f64)).collect();
        self.table.push(step, &averages)?;
        Ok(averages)
    }

    /// Writes the averages in progress into a checkpoint.
    pub(crate) fn save(&self, state: &mut State) {
        let names: Vec<&str> = self.sums.keys().map(String::as_str).collect();
        state.put("names", names.join("\n").into_bytes());
        state.put("sums", self.sums.values().map(|&(sum, _)| sum).collect::<Vec<f64>>());
        state.put("counts", self.sums.values().map(|&(_, count)| count).collect::<Vec<u64>>());
    }

    /// Continues with the averages that [`Metrics::save`] wrote.
    pub(crate) fn load(&mut self, state: &State) -> Result<()> {
        let names = String::from_utf8_lossy(state.get::<u8>("names")?).into_owned();
        let sums = state.get::<f64>("sums")?;
        let counts = state.get::<u64>("counts")?;
        let pairs = sums.iter().copied().zip(counts.iter().copied());
        self.sums = names.split('\n').map(str::to_owned).zip(pairs).collect();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use copq::Outcome;

    use super::*;

    fn metrics(path: &Path) -> Metrics {
        Metrics::of(Table::open(path, 0, |_| true).unwrap())
    }

    #[test]
    fn metrics_are_averages_over_the_interval() {
        let temporary = tempfile::tempdir().unwrap();
        let mut metrics = metrics(&temporary.path().join("metrics.csv"));
        metrics.scalar(1, "q/safety", 1.0);
        metrics.scalar(2, "q/safety", 2.0);
        let spec = EnvSpec::new("test", 1, 1).reward("speed", 1.0).reward("effort", 0.5);
        let episode = Episode { returns: vec![4.0, -2.0], length: 70, outcome: Outcome::Truncated };
        metrics.episode(2, &episode, &spec);
        let row = metrics.row(2).unwrap();
        let number = |name: &str| row.iter().find(|(column, _)| column == name).unwrap().1;
        assert_eq!(
            (number("q/safety"), number("train/weighted_total"), number("train/length")),
            (1.5, 3.0, 70.0)
        );
        assert!(metrics.row(3).unwrap().is_empty());
    }

    /// A name from an agent of one's own can neither damage the file nor come back from a
    /// checkpoint.
    #[test]
    fn a_scalar_that_no_column_can_be_is_refused() {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path().join("metrics.csv");
        let mut metrics = metrics(&path);
        for name in ["step", "", "a\nb", "\u{7}"] {
            metrics.scalar(1, "a", 1.0);
            metrics.scalar(1, "c", 3.0);
            metrics.scalar(1, name, 2.0);
            let mut saved = State::default();
            metrics.save(&mut saved);
            let error = metrics.row(1).unwrap_err().to_string();
            let wanted = "a scalar's name: wanted a text other than '' and 'step', without \
                          control characters, got ";
            assert_eq!(error, format!("{wanted}{name:?}"));
            metrics.load(&saved).unwrap();
            let row = [("a", 1.0), ("c", 3.0)].map(|(name, value)| (name.to_owned(), value));
            assert_eq!(metrics.row(2).unwrap(), row);
        }
        assert_eq!(
            std::fs::read_to_string(path).unwrap(),
            "step,a,c\n".to_owned() + &"2,1,3\n".repeat(4)
        );
    }
}
