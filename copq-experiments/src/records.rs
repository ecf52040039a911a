//! What a run writes down as it goes: the rows of its tables, TensorBoard's events, and which
//! evaluation was the best.

use std::path::PathBuf;

use copq::{EnvSpec, Error, Evaluation, Result, State, Timing, Trainer};

use crate::aside::lay_aside;
use crate::best::Best;
use crate::evaluations;
use crate::folder::{RunFolder, read_done};
use crate::metrics::Metrics;
use crate::numbers::grouped;
use crate::settings::RunSettings;
use crate::sheet::Sheet;
use crate::statistics::mean;
use crate::table::Table;
use crate::tensorboard::EventFile;
use crate::timings::Timings;

const METRICS: &str = "metrics.csv";
const EVALUATIONS: &str = "evaluations.csv";
const TIMINGS: &str = "timings.csv";

/// The tables and events of a run's folder.
#[derive(Debug)]
pub(crate) struct Records {
    pub metrics: Metrics,
    pub evaluations: Table,
    pub timings: Timings,
    events: EventFile,
    best: Best,
    /// Where the best policy has been set aside, if its row was dropped.
    pub best_before: Option<PathBuf>,
    settings: RunSettings,
    pub pace: Pace,
}

/// How many steps a trainer takes at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    pub worlds: u64,
}

impl Pace {
    /// Whether a step is the first one at or after a multiple of an interval.
    pub(crate) fn is_due(self, step: u64, every: u64) -> bool {
        let Some(after) = step.checked_rem(every) else { return step == 0 };
        after == 0 || (after < self.worlds && step >= every)
    }
}

impl Records {
    /// Takes up the run if its rows fit: opens or makes the files, and drops the rows that the run
    /// will write again when it continues from `saved`, where its trainer stands.
    pub(crate) fn open(
        folder: &mut RunFolder,
        settings: &RunSettings,
        saved: Option<&State>,
        trainer: &Trainer,
    ) -> Result<Self> {
        if saved.is_none() {
            check_not_begun(folder, trainer.env_count() as u64)?;
        }
        let step = trainer.steps();
        let spec = trainer.spec();
        let pace = Pace { worlds: trainer.env_count() as u64 };
        // Several environments may go beyond the last step that is wanted.
        let is_done = read_done(folder.path()).is_some() && step >= settings.steps;
        let table = |name: &str, every: u64| {
            // A row off its interval is the last one of a run that is done, or was the last one of
            // a shorter run.
            let keep =
                |row: u64| row <= step && (pace.is_due(row, every) || (is_done && row == step));
            Table::read(&folder.file(name), rows_of(saved, name), keep)
        };
        // All are read before the first is written: a run that cannot resume stays as it was.
        let rows = [
            table(METRICS, settings.log_every)?,
            table(EVALUATIONS, settings.eval_every)?,
            table(TIMINGS, settings.log_every)?,
        ];
        // Numbers that no row has any longer also disappear from TensorBoard.
        let last = rows.iter().filter_map(|rows| rows.steps().last().copied()).max();
        let first = last.map_or(0, |last| last + 1);
        // Before the rows after its checkpoint are dropped: a checkpoint that is set aside needs
        // them.
        folder.take_up()?;
        let (best, best_before) = keep_best(folder, &rows[1], spec)?;
        let start = |name: &str, rows: &Sheet| Table::start(&folder.file(name), rows);
        let mut metrics = Metrics::of(start(METRICS, &rows[0])?);
        if let Some(saved) = saved {
            metrics.load(saved.child("metrics")?)?;
        }
        Ok(Self {
            metrics,
            evaluations: start(EVALUATIONS, &rows[1])?,
            timings: Timings::of(start(TIMINGS, &rows[2])?, step),
            events: EventFile::create(folder.path(), first)?,
            best,
            best_before,
            settings: *settings,
            pace,
        })
    }

    /// Writes the averages and the times since the last row.
    pub(crate) fn log(&mut self, step: u64, timing: Timing) -> Result<()> {
        let averages = self.metrics.row(step)?;
        let times = self.timings.row(step, timing)?;
        self.events.scalars(step, &averages)?;
        self.events.scalars(step, &times)
    }

    /// Writes an evaluation's row.
    pub(crate) fn evaluated(
        &mut self,
        step: u64,
        evaluation: &Evaluation,
        spec: &EnvSpec,
    ) -> Result<()> {
        self.evaluations.push(step, &evaluations::columns(evaluation, spec))?;
        self.events.scalars(step, &evaluations::scalars(evaluation, spec))
    }

    /// Whether an evaluation is better than all before it. From now on it counts among them.
    pub(crate) fn is_best(&mut self, evaluation: &Evaluation, spec: &EnvSpec) -> bool {
        let total = mean(&evaluations::totals(evaluation, spec));
        self.best.update(&evaluation.mean(), total, spec)
    }

    /// Makes the rows durable, and writes their number and the averages in progress into the
    /// checkpoint: a run that resumes from it does not write them again.
    pub(crate) fn save(&self, state: &mut State) -> Result<()> {
        self.metrics.save(state.child_mut("metrics"));
        self.sync()?;
        let rows = state.child_mut("rows");
        for (name, table, every) in self.tables() {
            rows.put(name, [table.rows(|step| self.pace.is_due(step, every))]);
        }
        Ok(())
    }

    /// Makes the rows durable.
    pub(crate) fn sync(&self) -> Result<()> {
        self.tables().into_iter().try_for_each(|(_, table, _)| table.sync())
    }

    /// The tables, each with its name and its interval.
    fn tables(&self) -> [(&str, &Table, u64); 3] {
        let Self { metrics, evaluations, timings, settings, .. } = self;
        [
            (METRICS, &metrics.table, settings.log_every),
            (EVALUATIONS, evaluations, settings.eval_every),
            (TIMINGS, &timings.table, settings.log_every),
        ]
    }
}

/// How many rows of a table must be there according to the checkpoint; older checkpoints do not
/// say.
fn rows_of(saved: Option<&State>, name: &str) -> u64 {
    let rows = saved.and_then(|saved| saved.child("rows").ok());
    rows.and_then(|rows| rows.get_one(name).ok()).unwrap_or(0)
}

/// The best of the evaluations that stay. If there was a better one, its policy is kept under
/// another name, which is returned: a run that continues differently may do worse.
fn keep_best(folder: &RunFolder, rows: &Sheet, spec: &EnvSpec) -> Result<(Best, Option<PathBuf>)> {
    let policy = folder.file("policy-best.safetensors");
    // A run from before there were policy files starts to look for its best now.
    if !policy.exists() {
        return Ok((Best::default(), None));
    }
    let best = Best::of_rows(rows, spec);
    let is_dropped = !folder.file(EVALUATIONS).exists()
        || best != Best::of_rows(&all_rows(folder, EVALUATIONS)?, spec);
    let before = is_dropped.then(|| lay_aside(&policy, "policy-best-before")).transpose()?;
    Ok((best, before))
}

/// A table's rows, none if there is no file.
fn all_rows(folder: &RunFolder, name: &str) -> Result<Sheet> {
    let file = folder.file(name);
    if file.exists() { Sheet::read(&file) } else { Ok(Sheet::default()) }
}

/// An error for a folder that has lost its checkpoint: starting again would delete its results.
fn check_not_begun(folder: &RunFolder, worlds: u64) -> Result<()> {
    let mut last = None;
    for name in [EVALUATIONS, METRICS] {
        last = last.max(all_rows(folder, name)?.steps().last().copied());
    }
    match last {
        Some(step) if step >= folder.first_checkpoint.saturating_add(worlds) => {
            let what = format!("run folder '{}'", folder.path().display());
            let wanted = "its checkpoint.safetensors, to resume from (for a similar run in a new \
                 folder: copq train --like)";
            Err(Error::invalid(
                what,
                wanted,
                format!("none, but rows up to step {}", grouped(step)),
            ))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::Pace;

    #[test]
    fn several_worlds_are_due_when_they_have_passed() {
        let due = |worlds: u64, every: u64| -> Vec<u64> {
            let steps = (0..=30).map(|i| i * worlds).take_while(|&step| step <= 30);
            steps.filter(|&step| Pace { worlds }.is_due(step, every)).collect()
        };
        assert_eq!(due(1, 10), [0, 10, 20, 30]);
        assert_eq!(due(4, 10), [0, 12, 20]);
        assert_eq!(due(16, 10), [0, 16]);
        assert_eq!(due(3, 0), [0]);
    }
}
