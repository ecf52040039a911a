//! The driver: trains, evaluates, logs and saves, and can stop and resume between any two steps.

mod evaluating;

use std::fmt;
use std::time::{Duration, Instant};

use copq::{Agent, Env, Error, Observer, Result, State, Trainer};

use crate::checkpoints::remove_replay;
use crate::ending::{Ending, resume_command};
use crate::folder::RunFolder;
use crate::numbers::grouped;
use crate::progress::Progress;
use crate::records::Records;
use crate::settings::{OnEnvError, OnResume, RunSettings, SavedReplay};
use crate::stop::Stop;
use crate::timings;

/// After this many failures of an environment, without a good step between them, a run gives up.
const PATIENCE: u64 = 100;

/// A training run in its folder.
///
/// Rows are written at multiples of their interval, and once more at the end. A checkpoint holds
/// everything as it is after the rows of its step. Resuming from it drops later rows, so that a
/// resumed run's files equal those of an uninterrupted run.
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # use copq::{Env, EnvSpec};
/// # use world::World;
/// # let env = || World(EnvSpec::new("world", 1, 1).reward("time", 1.0).horizon(3), 0);
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("first");
/// use copq::{Agent, Learner, Method, Trainer};
/// use copq_candle::Candle;
/// use copq_experiments::{Plan, Run, RunFolder, RunSettings, Sheet};
///
/// // In an environment whose episodes return 1.5.
/// let method = Method::cop_td3();
/// let mut plan = Plan::new(&method);
/// plan.run = RunSettings { steps: 30, eval_every: 10, ..RunSettings::default() };
/// let folder = RunFolder::create(&path, &plan, &method.config)?;
/// let learner = Learner::new(method, env().spec(), &Candle::default(), plan.run.seed)?;
/// let agent: Box<dyn Agent> = Box::new(learner); // a run takes any
/// let trainer = Trainer::new(env(), agent)?;
/// Run::new(trainer, Some(Box::new(env())), folder, plan.run)?.silent().train()?;
///
/// let evaluations = Sheet::read(&path.join("evaluations.csv"))?;
/// assert_eq!(evaluations.steps(), [0, 10, 20, 30]);
/// assert_eq!(evaluations.column("return/time/mean"), Some(vec![1.5; 4]));
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Run {
    trainer: Trainer,
    eval_env: Option<Box<dyn Env>>,
    folder: RunFolder,
    settings: RunSettings,
    records: Records,
    progress: Progress,
    first_step: u64,
    /// What to say about settings that differ from those of the checkpoint it resumes from.
    changed: Option<String>,
    /// The step of the newest checkpoint.
    saved_step: Option<u64>,
    evaluation_time: Duration,
    /// Failures of the environment so far, and without a good step since.
    env_errors: u64,
    env_errors_in_a_row: u64,
}

impl fmt::Debug for Run {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Run")
            .field("trainer", &self.trainer)
            .field("folder", &self.folder)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl Run {
    /// Takes a fresh trainer, a separate environment for evaluation (a second instance of the same
    /// task; without one, evaluation borrows the trainer's) and a folder. Continues from the
    /// folder's checkpoint if it has one.
    pub fn new(
        mut trainer: Trainer,
        eval_env: Option<Box<dyn Env>>,
        mut folder: RunFolder,
        settings: RunSettings,
    ) -> Result<Self> {
        settings.check()?;
        if let Some(eval_env) = &eval_env {
            trainer.spec().check_same("environment for evaluation", eval_env.spec())?;
        }
        if settings.on_resume == OnResume::SameEpisode {
            // A checkpoint holds the environment in mid-episode. Better fail now than after the
            // first steps.
            trainer.env().save(&mut State::default()).map_err(cannot_go_on)?;
        }
        check_same_seed(&trainer, &settings)?;
        let saved = folder.load()?;
        if let Some(saved) = &saved {
            go_on(&mut trainer, &folder, saved)?;
        }
        let step = trainer.steps();
        let records = Records::open(&mut folder, &settings, saved.as_ref(), &trainer)?;
        Ok(Self {
            records,
            progress: Progress::new(step, settings.steps, &folder.file("log.txt")),
            first_step: step,
            changed: saved
                .as_ref()
                .and_then(|saved| folder.origin.change(saved.child("made_by").ok()?)),
            saved_step: saved.is_some().then_some(step),
            evaluation_time: Duration::ZERO,
            env_errors: saved.and_then(|saved| saved.get_one("env_errors").ok()).unwrap_or(0),
            env_errors_in_a_row: 0,
            trainer,
            eval_env,
            folder,
            settings,
        })
    }

    /// Shows nothing on standard error; `log.txt` is written all the same.
    pub fn silent(mut self) -> Self {
        self.progress.silence();
        self
    }

    /// The trainer with its agent.
    pub fn trainer_mut(&mut self) -> &mut Trainer {
        &mut self.trainer
    }

    /// The run's folder.
    pub fn folder(&self) -> &RunFolder {
        &self.folder
    }

    /// Trains to the last step, or until SIGINT, SIGTERM, SIGHUP or SIGUSR1 asks to stop.
    pub fn train(&mut self) -> Result<Ending> {
        let trained = self.train_to_the_end();
        if let Err(error) = &trained {
            self.progress.keep(&format!("error: {error}"));
        }
        trained
    }

    fn train_to_the_end(&mut self) -> Result<Ending> {
        let stop = Stop::catch()?;
        let began = Instant::now();
        let step = grouped(self.first_step);
        let steps = grouped(self.settings.steps);
        let path = self.folder.path().display();
        self.progress.line(&format!("from step {step} to {steps}, in {path}"));
        if let Some(change) = self.changed.take() {
            self.progress.line(&change);
        }
        if let Some(file) = self.records.best_before.take() {
            let file = file.display();
            self.progress.line(&format!(
                "the best evaluation yet is no longer among the rows; its policy is kept as {file}"
            ));
        }
        let is_due = self.is_evaluation_due();
        if is_due {
            self.evaluate(&stop)?;
            // The existing checkpoint does not know about its row.
            self.saved_step = None;
        }
        while self.trainer.steps() < self.settings.steps && !stop.is_asked() {
            self.step(&stop)?;
        }
        if self.saved_step != Some(self.trainer.steps()) {
            if stop.is_asked() {
                let again = if stop.is_interrupted() { " (Ctrl-C again: stop now)" } else { "" };
                self.progress.line(&format!("stopping after saving{again}"));
            }
            self.checkpoint()?;
        }
        let ending = self.close(&stop)?;
        if self.trainer.steps() > self.first_step {
            self.progress.line(&self.describe_time(began.elapsed()));
        } else if matches!(ending, Ending::Finished { .. }) && !is_due {
            let text = format!("nothing to do: all {steps} steps are done (more with --steps)");
            self.progress.line(&text);
        }
        self.progress.finish();
        Ok(ending)
    }

    fn step(&mut self, stop: &Stop) -> Result<()> {
        let before = self.trainer.steps();
        let stepped = self.trainer.step(&mut self.records.metrics);
        let (episodes, failure) = match stepped {
            Err(error) if self.trainer.env_failed() => {
                (self.trainer.cut_short().to_vec(), Some(error))
            }
            stepped => (stepped?, None),
        };
        let step = self.trainer.steps();
        self.progress.step(step);
        for warning in self.records.metrics.take_warnings() {
            self.progress.line(&warning);
        }
        for episode in episodes {
            let spec = self.trainer.spec();
            self.records.metrics.episode(step, &episode, spec);
            self.progress.episode(&episode, &spec.weights());
        }
        // Several environments take several steps at once.
        let has_passed = |every: u64| step / every > before / every;
        self.env_errors += u64::from(failure.is_some());
        if has_passed(self.settings.log_every) {
            self.log()?;
        }
        match failure {
            None => self.env_errors_in_a_row = 0,
            // A signal to all processes also ends an environment in another process.
            Some(_) if stop.is_asked() => return Ok(()),
            Some(error) => self.env_failed(error)?,
        }
        if self.settings.eval_every > 0 && has_passed(self.settings.eval_every) {
            self.evaluate(stop)?;
        }
        if has_passed(self.settings.checkpoint_every) && !stop.is_asked() {
            self.checkpoint()?;
        }
        Ok(())
    }

    /// The episode ends where it was. The run is saved and ends here, or continues with the next
    /// one.
    fn env_failed(&mut self, error: Error) -> Result<()> {
        self.env_errors_in_a_row += 1;
        let step = grouped(self.trainer.steps());
        let goes_on = self.settings.on_env_error == OnEnvError::Reset;
        if goes_on && self.env_errors_in_a_row < PATIENCE {
            let text = format!("after step {step}: {error}; the episode counts as truncated");
            self.progress.line(&text);
            return Ok(());
        }
        self.checkpoint()?;
        let command = resume_command(self.folder.path());
        let what = if goes_on {
            format!("the environment failed {PATIENCE} times in a row after step {step}")
        } else {
            format!(
                "the environment failed after step {step}; the run is saved there ({command} \
                 continues with a new episode; --on-env-error reset does so automatically)"
            )
        };
        Err(Error::other(what, error))
    }

    fn log(&mut self) -> Result<()> {
        self.folder.check_held()?;
        let step = self.trainer.steps();
        if self.env_errors > 0 {
            self.records.metrics.scalar(step, "env_errors", self.env_errors as f64);
        }
        self.records.log(step, self.trainer.timing())
    }

    /// Writes the policy to a file of its own, if the agent has one to write.
    fn save_policy(&self, name: &str) -> Result<()> {
        self.folder.check_held()?;
        match self.trainer.agent().save_policy(&self.folder.file(name)) {
            Err(Error::Unsupported { .. }) => Ok(()),
            saved => saved,
        }
    }

    fn checkpoint(&mut self) -> Result<()> {
        let mut state = State::default();
        let trainer = state.child_mut("trainer");
        match self.settings.on_resume {
            OnResume::SameEpisode => self.trainer.save(trainer)?,
            OnResume::NewEpisode => self.trainer.save_without_episodes(trainer)?,
        }
        self.records.save(&mut state)?;
        state.put("env_errors", [self.env_errors]);
        self.folder.origin.save(state.child_mut("made_by"))?;
        if self.settings.replay == SavedReplay::None {
            remove_replay(&mut state);
        }
        self.folder.save(&state)?;
        self.saved_step = Some(self.trainer.steps());
        self.save_policy("policy.safetensors")
    }

    /// Writes the last rows, which a longer run would not have; the checkpoint does not know about
    /// them.
    fn close(&mut self, stop: &Stop) -> Result<Ending> {
        let step = self.trainer.steps();
        let folder = self.folder.path().to_owned();
        if step < self.settings.steps {
            return Ok(Ending::Interrupted { step, folder });
        }
        if self.records.metrics.table.last() != Some(step) {
            self.log()?;
        }
        let is_evaluated = |run: &Self| {
            run.settings.eval_every == 0 || run.records.evaluations.last() == Some(step)
        };
        if !is_evaluated(self) {
            self.evaluate(stop)?;
        }
        if stop.is_asked() && !is_evaluated(self) {
            return Ok(Ending::Interrupted { step, folder });
        }
        // Last of all, while nobody else can write here.
        self.records.sync()?;
        self.folder.finish()?;
        Ok(Ending::Finished { folder })
    }

    fn describe_time(&self, total: Duration) -> String {
        let steps = self.trainer.steps() - self.first_step;
        timings::describe(steps, total, self.trainer.timing(), self.evaluation_time)
    }
}

fn go_on(trainer: &mut Trainer, folder: &RunFolder, saved: &State) -> Result<()> {
    let loaded = saved.child("trainer").and_then(|saved| trainer.load(saved));
    loaded.map_err(|e| Error::other(format!("resuming from '{}'", folder.start().display()), e))
}

/// The error for an environment that cannot be saved, with advice.
fn cannot_go_on(error: Error) -> Error {
    let Error::Unsupported { what } = error else { return error };
    let advice = "RunSettings::on_resume = OnResume::NewEpisode lets a run begin a new episode when it \
                  resumes";
    Error::Unsupported { what: format!("{what}; {advice}") }
}

fn check_same_seed(trainer: &Trainer, settings: &RunSettings) -> Result<()> {
    let seed = trainer.agent().seed();
    if seed == settings.seed {
        return Ok(());
    }
    Err(Error::invalid("the agent's seed", format!("{} (the run's)", settings.seed), seed))
}
