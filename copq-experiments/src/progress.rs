//! What the user sees of a run: a bar on a terminal, plain lines in a log file. All of it goes to
//! standard error.

use std::fmt;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use copq::Episode;
use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use crate::numbers::{grouped, weighted_total};

const BAR: &str = "{wide_bar} {human_pos}/{human_len} steps, {rate}, {eta} left  {msg}";

/// Longest silence in a log file.
const SILENCE: Duration = Duration::from_secs(60);

/// Shows how far a run is.
#[derive(Debug)]
pub(crate) enum Progress {
    Silent,
    Bar(ProgressBar),
    Lines(Lines),
}

impl Progress {
    /// A bar if standard error is a terminal, else lines.
    pub(crate) fn new(step: u64, steps: u64) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self::Lines(Lines {
                steps,
                printed: Instant::now(),
                since: Instant::now(),
                last_step: step,
            });
        }
        let bar = ProgressBar::new(steps).with_position(step);
        if let Ok(style) = ProgressStyle::with_template(BAR) {
            bar.set_style(style.with_key("rate", write_rate));
        }
        bar.reset_eta();
        Self::Bar(bar)
    }

    /// One more step is done.
    pub(crate) fn step(&mut self, step: u64) {
        match self {
            Self::Silent => {}
            Self::Bar(bar) => bar.set_position(step),
            Self::Lines(lines) => lines.step(step),
        }
    }

    /// A training episode is over.
    pub(crate) fn episode(&mut self, episode: &Episode, weights: &[f32]) {
        if let Self::Bar(bar) = self {
            bar.set_message(format!(
                "last episode {:.1}",
                weighted_total(&episode.returns, weights)
            ));
        }
    }

    /// Prints a line that stays.
    pub(crate) fn line(&mut self, text: &str) {
        match self {
            Self::Silent => {}
            Self::Bar(bar) => bar.suspend(|| eprintln!("{text}")),
            Self::Lines(lines) => {
                eprintln!("{text}");
                lines.printed = Instant::now();
            }
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&mut self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

fn write_rate(state: &ProgressState, text: &mut dyn fmt::Write) {
    // Nothing can go wrong with a line in memory.
    write!(text, "{:.0} steps/s", state.per_sec()).unwrap_or_default();
}

/// Breaks a long silence with how far and how fast it goes.
#[derive(Debug)]
pub(crate) struct Lines {
    steps: u64,
    /// When any line was last printed.
    printed: Instant,
    /// When, and at which step, the speed was last told.
    since: Instant,
    last_step: u64,
}

impl Lines {
    fn step(&mut self, step: u64) {
        // A look at the clock costs as much as a small environment's step.
        if !step.is_multiple_of(256) || self.printed.elapsed() < SILENCE {
            return;
        }
        let rate = (step - self.last_step) as f64 / self.since.elapsed().as_secs_f64();
        let minutes = (self.steps - step) as f64 / rate / 60.0;
        eprintln!(
            "{:>9} of {} steps, {rate:.0} steps/s, {minutes:.0} min left",
            grouped(step),
            grouped(self.steps)
        );
        (self.printed, self.since, self.last_step) = (Instant::now(), Instant::now(), step);
    }
}
