//! What the user sees of a run: a bar on a terminal, plain lines in a log file. All of it goes to
//! standard error.

use std::fmt;
use std::fs::File;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use copq::Episode;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use crate::numbers::{grouped, weighted_total};

const BAR: &str = "{wide_bar} {human_pos}/{human_len} steps, {rate}, {eta} left  {msg}";

/// Longest silence in a log file.
const SILENCE: Duration = Duration::from_secs(60);

/// Shows how far a run is, and keeps its messages in the folder's `log.txt`. A message that cannot
/// be written is lost; that is no reason to end a run.
#[derive(Debug)]
pub(crate) struct Progress {
    shown: Shown,
    log: Option<File>,
}

#[derive(Debug)]
enum Shown {
    Nothing,
    Bar(ProgressBar),
    Lines(Lines),
}

impl Progress {
    /// A bar if standard error is a terminal, else lines.
    pub(crate) fn new(step: u64, steps: u64, log: &Path) -> Self {
        let log = File::options().create(true).append(true).open(log).ok();
        if !std::io::stderr().is_terminal() {
            let now = Instant::now();
            let lines = Lines { steps, printed: now, since: now, last_step: step, looked: step };
            return Self { shown: Shown::Lines(lines), log };
        }
        let bar = ProgressBar::new(steps).with_position(step);
        if let Ok(style) = ProgressStyle::with_template(BAR) {
            bar.set_style(style.with_key("rate", write_rate));
        }
        bar.reset_eta();
        Self { shown: Shown::Bar(bar), log }
    }

    /// Shows nothing any more; the log continues.
    pub(crate) fn silence(&mut self) {
        self.shown = Shown::Nothing;
    }

    /// One more step is done.
    pub(crate) fn step(&mut self, step: u64) {
        match &mut self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => bar.set_position(step),
            Shown::Lines(lines) => lines.step(step),
        }
    }

    /// A training episode is over.
    pub(crate) fn episode(&mut self, episode: &Episode, weights: &[f32]) {
        if let Shown::Bar(bar) = &self.shown {
            bar.set_message(format!(
                "last episode {:.1}",
                weighted_total(&episode.returns, weights)
            ));
        }
    }

    /// Keeps a line in the log without printing it.
    pub(crate) fn keep(&mut self, text: &str) {
        if let Some(log) = &mut self.log {
            log.write_all(format!("{text}\n").as_bytes()).unwrap_or_default();
        }
    }

    /// Prints a line that stays.
    pub(crate) fn line(&mut self, text: &str) {
        self.keep(text);
        match &mut self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => bar.suspend(|| tell(text)),
            Shown::Lines(lines) => {
                tell(text);
                lines.printed = Instant::now();
            }
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&mut self) {
        if let Shown::Bar(bar) = &self.shown {
            bar.finish_and_clear();
        }
    }
}

/// A line on standard error, if anybody listens.
fn tell(text: &str) {
    writeln!(std::io::stderr(), "{text}").unwrap_or_default();
}

fn write_rate(state: &ProgressState, text: &mut dyn fmt::Write) {
    // Writing to memory cannot fail.
    write!(text, "{:.0} steps/s", state.per_sec()).unwrap_or_default();
}

/// Breaks a long silence by printing how far the run is and how fast it goes.
#[derive(Debug)]
pub(crate) struct Lines {
    steps: u64,
    /// When any line was last printed.
    printed: Instant,
    /// When, and at which step, the speed was last reported.
    since: Instant,
    last_step: u64,
    /// The step of the last look at the clock.
    looked: u64,
}

impl Lines {
    fn step(&mut self, step: u64) {
        // A look at the clock costs as much as a small environment's step.
        if step / 256 == self.looked / 256 {
            return;
        }
        self.looked = step;
        if self.printed.elapsed() < SILENCE {
            return;
        }
        let rate = (step - self.last_step) as f64 / self.since.elapsed().as_secs_f64();
        // Several environments may go past the end together.
        let minutes = self.steps.saturating_sub(step) as f64 / rate / 60.0;
        tell(&format!(
            "{:>9} of {} steps, {rate:.0} steps/s, {minutes:.0} min left",
            grouped(step),
            grouped(self.steps)
        ));
        (self.printed, self.since, self.last_step) = (Instant::now(), Instant::now(), step);
    }
}
