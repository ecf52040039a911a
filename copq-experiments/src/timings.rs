//! `timings.csv`: where the time of each logging interval went. It is kept apart from the metrics,
//! which are the same every time a run is made.

use std::time::{Duration, Instant};

use copq::{Result, Timing};

use crate::numbers::Numbers;
use crate::table::Table;

/// Seconds of each logging interval; restarted, not restored, on resume.
#[derive(Debug)]
pub(crate) struct Timings {
    pub table: Table,
    began: Instant,
    first_step: u64,
    before: Timing,
    evaluation: Duration,
}

impl Timings {
    /// Starts the clock.
    pub(crate) fn of(table: Table, step: u64) -> Self {
        let before = Timing::default();
        let evaluation = Duration::ZERO;
        Self { table, began: Instant::now(), first_step: step, before, evaluation }
    }

    /// Adds an evaluation's time.
    pub(crate) fn evaluated(&mut self, time: Duration) {
        self.evaluation += time;
    }

    /// Writes the interval up to `step` and returns what TensorBoard gets; `timing` counts from the
    /// start.
    pub(crate) fn row(&mut self, step: u64, timing: Timing) -> Result<Numbers> {
        let seconds = self.began.elapsed().as_secs_f64();
        let numbers = [
            ("steps_per_second", (step - self.first_step) as f64 / seconds),
            ("seconds", seconds),
            ("act", (timing.act - self.before.act).as_secs_f64()),
            ("env", (timing.env - self.before.env).as_secs_f64()),
            ("update", (timing.update - self.before.update).as_secs_f64()),
            ("evaluation", self.evaluation.as_secs_f64()),
        ];
        let numbers: Numbers = numbers.map(|(name, value)| (name.to_owned(), value)).into();
        self.table.push(step, &numbers)?;
        (self.began, self.first_step, self.before, self.evaluation) =
            (Instant::now(), step, timing, Duration::ZERO);
        Ok(numbers.into_iter().map(|(name, value)| (format!("time/{name}"), value)).collect())
    }
}

/// One line for the terminal: the shares of the time since the start, in per cent.
pub(crate) fn describe(
    steps: u64,
    total: Duration,
    timing: Timing,
    evaluation: Duration,
) -> String {
    let share = |part: Duration| 100.0 * part.as_secs_f64() / total.as_secs_f64();
    let rest = total.saturating_sub(timing.act + timing.env + timing.update + evaluation);
    format!(
        "{:.0} steps/s; time: acting {:.0}%, environment {:.0}%, updates {:.0}%, evaluation \
         {:.0}%, saving and drawing {:.0}%",
        steps as f64 / total.as_secs_f64(),
        share(timing.act),
        share(timing.env),
        share(timing.update),
        share(evaluation),
        share(rest),
    )
}
