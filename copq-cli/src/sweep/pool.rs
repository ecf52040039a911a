//! A pool of processes, one a run.

use std::fs::{self, File};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{available_parallelism, sleep};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use copq::files;
use signal_hook::consts::{SIGINT, SIGTERM};

use super::file::SweepFile;
use super::status::{State, failure, steps};
use super::task::STOPPED;
use crate::options::{note, say};

/// How often the processes are looked at.
const PAUSE: Duration = Duration::from_millis(200);
/// How often a view that cannot be overwritten is written.
const REPORT: Duration = Duration::from_secs(60);

struct Running {
    number: usize,
    child: Child,
}

/// What is known of a sweep while it runs.
struct Pool<'a> {
    file: &'a Path,
    sweep: SweepFile,
    waiting: Vec<usize>,
    running: Vec<Running>,
    failed: usize,
    began: Instant,
    /// Steps that were there before, and that there shall be.
    before: u64,
    all: u64,
    shown: Instant,
}

pub fn run(file: &Path, jobs: Option<usize>) -> anyhow::Result<()> {
    let sweep = SweepFile::read(file)?;
    let jobs = jobs.unwrap_or_else(|| available_parallelism().map_or(1, usize::from));
    let state = |&number: &usize| State::of(&sweep.tasks[number].folder);
    let mut waiting: Vec<_> =
        (0..sweep.tasks.len()).filter(|number| state(number) != State::Done).collect();
    waiting.reverse();
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, stop.clone()).context("catching signals")?;
    }
    let before = sweep.tasks.iter().map(|task| steps(&task.folder)).sum();
    let plans = sweep.tasks.iter().filter_map(|task| task.prepare().ok());
    let all = plans.map(|prepared| prepared.plan.run.steps).sum();
    let now = Instant::now();
    let mut pool = Pool {
        file,
        sweep,
        waiting,
        running: Vec::new(),
        failed: 0,
        began: now,
        before,
        all,
        shown: now,
    };
    say(&format!("{} runs, {} of them done\n", pool.sweep.tasks.len(), pool.done()))?;
    let mut told = false;
    while !pool.running.is_empty() || (!pool.waiting.is_empty() && !told) {
        if stop.load(Ordering::Relaxed) && !told {
            told = true;
            pool.stop();
        }
        while !told && pool.running.len() < jobs {
            let Some(number) = pool.waiting.pop() else { break };
            pool.start(number)?;
        }
        pool.look()?;
        sleep(PAUSE);
    }
    pool.show(true);
    match (told, pool.failed) {
        (true, _) => {
            say("stopped, all saved; the same command goes on\n")?;
            std::process::exit(STOPPED)
        }
        (_, 0) => Ok(()),
        (_, failed) => bail!("{failed} runs failed; copq sweep status {} says why", file.display()),
    }
}

/// Where a run's words on standard error go while it runs.
fn words(folder: &Path) -> PathBuf {
    folder.with_added_extension("err")
}

/// The error that ended a run, of those words.
fn complaint(folder: &Path) -> Option<String> {
    let text = fs::read_to_string(words(folder)).ok()?;
    text.lines().find_map(|line| line.strip_prefix("Error: ")).map(str::to_owned)
}

impl Pool<'_> {
    fn start(&mut self, number: usize) -> anyhow::Result<()> {
        // What a run says lies in its folder's log.txt, but for why it could not even begin.
        let words = words(&self.sweep.tasks[number].folder);
        if let Some(folder) = words.parent() {
            fs::create_dir_all(folder).map_err(files::failed("making", folder))?;
        }
        let words = File::create(&words).map_err(files::failed("making", &words))?;
        let child = Command::new(std::env::current_exe()?)
            .args(["sweep", "task"])
            .arg(self.file)
            .args(["--task", &number.to_string()])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(words)
            .spawn()
            .context("starting a run")?;
        self.running.push(Running { number, child });
        Ok(())
    }

    /// Asks every run to save and end. A terminal's Ctrl-C has reached them already; twice does no
    /// harm.
    fn stop(&self) {
        for running in &self.running {
            let id = running.child.id().to_string();
            let killed = Command::new("kill").args(["-TERM", &id]).status();
            if killed.is_err() {
                note(&format!("process {id} could not be told to stop"));
            }
        }
    }

    /// Takes in the runs that have ended.
    fn look(&mut self) -> anyhow::Result<()> {
        let mut i = 0;
        while i < self.running.len() {
            let Some(status) = self.running[i].child.try_wait()? else {
                i += 1;
                continue;
            };
            let Running { number, .. } = self.running.swap_remove(i);
            let folder = &self.sweep.tasks[number].folder;
            let name = folder.display();
            let complaint = complaint(folder);
            fs::remove_file(words(folder)).unwrap_or_default();
            match status.code() {
                Some(0) => say(&format!("{}{name} is done\n", self.clear()))?,
                Some(STOPPED) => {}
                _ => {
                    self.failed += 1;
                    let why = failure(folder).or(complaint).unwrap_or_else(|| status.to_string());
                    say(&format!("{}{name} failed: {why}\n", self.clear()))?;
                }
            }
        }
        self.show(false);
        Ok(())
    }

    fn done(&self) -> usize {
        let done = |task: &&super::file::Task| State::of(&task.folder) == State::Done;
        self.sweep.tasks.iter().filter(done).count()
    }

    fn clear(&self) -> &'static str {
        if std::io::stderr().is_terminal() { "\r\x1b[K" } else { "" }
    }

    /// One line for all runs: overwritten on a terminal, now and then elsewhere.
    fn show(&mut self, is_last: bool) {
        let live = std::io::stderr().is_terminal();
        let pause = if live { Duration::from_secs(2) } else { REPORT };
        if self.shown.elapsed() < pause && !is_last {
            return;
        }
        self.shown = Instant::now();
        let now: u64 = self.sweep.tasks.iter().map(|task| steps(&task.folder)).sum();
        let seconds = self.began.elapsed().as_secs_f64();
        let rate = now.saturating_sub(self.before) as f64 / seconds;
        let left = self.all.saturating_sub(now) as f64 / rate / 60.0;
        let left =
            if left.is_finite() { format!(", {left:.0} minutes left") } else { String::new() };
        let total = self.sweep.tasks.len();
        let text = format!(
            "{} of {total} done, {} running, {} failed; {rate:.0} steps/s{left}",
            self.done(),
            self.running.len(),
            self.failed
        );
        let mut out = std::io::stderr();
        let end = if live && !is_last { "" } else { "\n" };
        write!(out, "{}{text}{end}", self.clear()).and_then(|()| out.flush()).unwrap_or_default();
    }
}
