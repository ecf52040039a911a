//! A pool of processes, one for each run.

use std::fs::{self, File};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus, Stdio};
use std::thread::{available_parallelism, sleep};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use copq::files;
use copq_experiments::{Stop, complaint_file, failure, held_by, steps_done};

use super::cores::cores;
use super::file::SweepFile;
use super::process::{terminate, this_program, was_told_to_end};
use super::task::HELD;
use crate::options::{count, note, say};
use crate::training::STOPPED;

/// A run's exit code after a second Ctrl-C.
const INTERRUPTED: i32 = 130;
/// How often the processes are looked at.
const PAUSE: Duration = Duration::from_millis(200);
/// How often a view that cannot be overwritten is written.
const REPORT: Duration = Duration::from_secs(60);

/// Trains all runs that are not done yet, several at once. Ctrl-C saves them all.
#[derive(clap::Args)]
pub struct Run {
    #[command(flatten)]
    named: super::Named,

    /// Number of runs at the same time, each in its own process. [default: one per core, fewer if
    /// runs have threads]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    jobs: Option<usize>,

    /// Let the system place the runs, instead of giving each its own core (Linux).
    #[arg(long)]
    no_pin: bool,
}

struct Running {
    number: usize,
    child: Child,
    core: Option<usize>,
    /// Steps that it had when it began here.
    before: u64,
}

/// What is known of a sweep while it runs.
struct Pool<'a> {
    file: &'a Path,
    sweep: SweepFile,
    /// Runs that are not done, the next one last.
    waiting: Vec<usize>,
    running: Vec<Running>,
    /// Cores that no run here uses.
    free: Vec<usize>,
    done: usize,
    failed: usize,
    /// Runs that were stopped and saved, those that ended unsaved, and those that another process
    /// had.
    stopped: usize,
    killed: usize,
    held: usize,
    began: Instant,
    /// Steps that ended runs did here.
    stepped: u64,
    shown: Instant,
}

impl Run {
    pub fn run(self) -> anyhow::Result<()> {
        let sweep = SweepFile::read_to_begin(&self.named.file)?;
        let mut free = cores();
        let all = available_parallelism().map_or(1, usize::from);
        // A container may have fewer processors than there are to be pinned to.
        let places = if free.is_empty() { all } else { free.len().min(all) };
        let threads = sweep.tasks.iter().map(|task| task.plan.threads).max().unwrap_or(1);
        let jobs = self.jobs.unwrap_or((places / threads).max(1));
        // With fewer runs than cores the system places them: another sweep may want the others.
        if self.no_pin || threads > 1 || jobs != free.len() {
            free.clear();
        }
        let mut waiting = sweep.undone();
        waiting.reverse();
        let now = Instant::now();
        let mut pool = Pool {
            file: &self.named.file,
            done: sweep.tasks.len() - waiting.len(),
            sweep,
            waiting,
            running: Vec::new(),
            free,
            failed: 0,
            stopped: 0,
            killed: 0,
            held: 0,
            began: now,
            stepped: 0,
            shown: now,
        };
        pool.run(jobs)
    }
}

/// Where a run's standard error goes while it runs here.
fn words(folder: &Path) -> PathBuf {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    folder.with_file_name(format!(".{name}.{}.err", std::process::id()))
}

/// Removes what a run said under pools that were killed.
fn forget_words(folder: &Path) {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let entries = folder.parent().and_then(|folder| fs::read_dir(folder).ok());
    for entry in entries.into_iter().flatten().flatten() {
        let file = entry.file_name().to_string_lossy().into_owned();
        let id = file.strip_prefix(&format!(".{name}.")).and_then(|rest| rest.strip_suffix(".err"));
        if id.is_some_and(|id| id.bytes().all(|byte| byte.is_ascii_digit())) {
            fs::remove_file(entry.path()).unwrap_or_default();
        }
    }
}

/// Keeps what a run said on standard error beside its folder if it failed without leaving the
/// reason itself, as after a panic. If the system ended it, because of a fault in the program or a
/// lack of memory, that is added.
fn keep_words(folder: &Path, is_failure: bool, status: ExitStatus) {
    let words = words(folder);
    let kept = complaint_file(folder);
    // A help for people, which no run depends on: a full disk may refuse it.
    if !is_failure || kept.exists() {
        return fs::remove_file(words).unwrap_or_default();
    }
    if status.code().is_none() {
        let opened = File::options().append(true).open(&words);
        let written = opened.and_then(|mut file| write!(file, "\nError: ended by {status}\n"));
        written.unwrap_or_default();
    }
    fs::rename(words, kept).unwrap_or_default();
}

impl Pool<'_> {
    fn run(&mut self, jobs: usize) -> anyhow::Result<()> {
        let stop = Stop::catch()?;
        say(&format!("{} runs, {} of them done\n", self.sweep.tasks.len(), self.done))?;
        let mut told = false;
        while !self.running.is_empty() || (!self.waiting.is_empty() && !told) {
            if stop.is_asked() && !told {
                told = true;
                self.stop();
            }
            while !told && self.running.len() < jobs {
                let Some(number) = self.waiting.pop() else { break };
                if let Err(error) = self.start(number) {
                    // The runs in progress are not abandoned for it.
                    self.failed += 1;
                    self.tell(number, &format!("could not be started: {error:#}"));
                }
            }
            self.look();
            sleep(PAUSE);
        }
        self.show(true);
        self.end()
    }

    /// Reports how the sweep ended.
    fn end(&self) -> anyhow::Result<()> {
        let file = self.file.display();
        if self.failed > 0 {
            bail!("{} runs failed; copq sweep status {file} says why", self.failed)
        }
        if self.done == self.sweep.tasks.len() {
            return Ok(());
        }
        let mut text = String::new();
        for (count, what) in [
            (self.stopped, "stopped and saved"),
            (self.killed, "ended at once and continue from their last checkpoint"),
            (self.held, "belong to other processes (copq sweep status says which)"),
            (self.waiting.len(), "wait"),
        ] {
            if count > 0 {
                text += &format!("{count} runs {what}\n");
            }
        }
        say(&(text + "run the same command again to continue\n"))?;
        std::process::exit(STOPPED)
    }

    fn start(&mut self, number: usize) -> anyhow::Result<()> {
        let task = &self.sweep.tasks[number];
        let folder = &task.folder;
        // What a run says is in its folder's log.txt, except for why it could not even begin.
        let words = words(folder);
        if let Some(folder) = words.parent() {
            fs::create_dir_all(folder).map_err(files::failed("making", folder))?;
        }
        // What an earlier failure said is not this one's reason.
        if held_by(folder).is_none() {
            fs::remove_file(complaint_file(folder)).unwrap_or_default();
            forget_words(folder);
        }
        let before = steps_done(folder);
        let words = File::create(&words).map_err(files::failed("making", &words))?;
        let core = self.free.pop();
        let on_core = core.map(|core| ["--core".to_owned(), core.to_string()]);
        let child = this_program()?
            .args(["sweep", "task"])
            .arg(self.file)
            .args(["--task", &number.to_string(), "--expect", &task.fingerprint])
            .args(on_core.into_iter().flatten())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(words)
            .spawn();
        match child {
            Ok(child) => self.running.push(Running { number, child, core, before }),
            Err(error) => {
                self.free.extend(core);
                return Err(error).context("starting its process");
            }
        }
        Ok(())
    }

    /// Asks every run to save and end. A terminal's Ctrl-C has reached them already; a second
    /// signal of another kind does no harm.
    fn stop(&self) {
        for running in &self.running {
            if let Err(error) = terminate(&running.child) {
                let id = running.child.id();
                note(&format!("process {id} could not be told to stop: {error}"));
            }
        }
    }

    /// Handles the runs that have ended.
    fn look(&mut self) {
        let mut i = 0;
        while i < self.running.len() {
            match self.running[i].child.try_wait() {
                Ok(Some(status)) => {
                    let ended = self.running.swap_remove(i);
                    self.take_in(ended, status);
                }
                // What cannot be waited for is looked at again.
                Ok(None) | Err(_) => i += 1,
            }
        }
        self.show(false);
    }

    fn take_in(&mut self, ended: Running, status: ExitStatus) {
        let Running { number, core, before, .. } = ended;
        let folder = self.sweep.tasks[number].folder.clone();
        self.stepped += steps_done(&folder).saturating_sub(before);
        self.free.extend(core);
        let was_asked = status.code() == Some(INTERRUPTED) || was_told_to_end(status);
        let is_failure = !(was_asked || matches!(status.code(), Some(0 | STOPPED | HELD)));
        keep_words(&folder, is_failure, status);
        match status.code() {
            _ if was_asked => {
                self.killed += 1;
                self.tell(number, &format!("ended at once: {status}"));
            }
            Some(0) => {
                self.done += 1;
                self.tell(number, "is done");
            }
            Some(STOPPED) => self.stopped += 1,
            Some(HELD) => {
                self.held += 1;
                self.tell(number, "belongs to another process");
            }
            _ => {
                self.failed += 1;
                let why = failure(&folder).unwrap_or_else(|| status.to_string());
                self.tell(number, &format!("failed: {why}"));
            }
        }
    }

    /// Reports what has become of a run; that nobody reads it is no reason to stop.
    fn tell(&self, number: usize, what: &str) {
        let name = self.sweep.tasks[number].folder.display();
        say(&format!("{}{name} {what}\n", clear())).unwrap_or_default();
    }

    /// One line for all runs: overwritten on a terminal, now and then elsewhere.
    fn show(&mut self, is_last: bool) {
        let live = std::io::stderr().is_terminal();
        let pause = if live { Duration::from_secs(2) } else { REPORT };
        if self.shown.elapsed() < pause && !is_last {
            return;
        }
        self.shown = Instant::now();
        let text = self.progress();
        let mut out = std::io::stderr();
        let end = if live && !is_last { "" } else { "\n" };
        write!(out, "{}{text}{end}", clear()).and_then(|()| out.flush()).unwrap_or_default();
    }

    fn progress(&self) -> String {
        let tasks = &self.sweep.tasks;
        // What is left of those that run, and what they have done here.
        let rest = |number: usize| {
            let task = &tasks[number];
            task.plan.run.steps.saturating_sub(steps_done(&task.folder))
        };
        let mut left: u64 = self.waiting.iter().map(|&number| rest(number)).sum();
        let mut stepped = self.stepped;
        for running in &self.running {
            let task = &tasks[running.number];
            let now = steps_done(&task.folder);
            left += rest(running.number);
            stepped += now.saturating_sub(running.before);
        }
        let rate = stepped as f64 / self.began.elapsed().as_secs_f64();
        let minutes = left as f64 / rate / 60.0;
        let minutes = if minutes.is_finite() {
            format!(", {minutes:.0} minutes left")
        } else {
            String::new()
        };
        format!(
            "{} of {} done, {} running, {} failed; {rate:.0} steps/s{minutes}",
            self.done,
            tasks.len(),
            self.running.len(),
            self.failed
        )
    }
}

/// What makes room for a line on a terminal.
fn clear() -> &'static str {
    if std::io::stderr().is_terminal() { "\r\x1b[K" } else { "" }
}
