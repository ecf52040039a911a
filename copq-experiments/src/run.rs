//! The driver: trains, evaluates, logs and saves, and can stop and go on between any two steps.

use std::fmt;
use std::time::{Duration, Instant};

use copq::{Agent, Env, Error, Observer, Result, State, Trainer, evaluate};

use crate::best::Best;
use crate::ending::Ending;
use crate::evaluations::{self, Evaluations};
use crate::figure;
use crate::folder::{RunFolder, remove_replay};
use crate::metrics::Metrics;
use crate::numbers::grouped;
use crate::plan::{OnEnvError, RunSettings, SavedReplay};
use crate::progress::Progress;
use crate::sheet::Sheet;
use crate::stop::Stop;
use crate::table::Table;
use crate::tensorboard::EventFile;
use crate::timings::{self, Timings};
use crate::watched::Watched;

/// Failures of an environment without a good step between them, after which it is given up.
const PATIENCE: u64 = 100;

/// A training run in its folder.
///
/// Rows are written at multiples of their interval, and once more at the end. A checkpoint holds
/// everything after the rows of its step; going on from it drops later rows, so that a resumed
/// run's files equal an uninterrupted one's.
///
/// ```
/// # use copq::{Agent, Env, EnvSpec, Mode, Outcome, Result, State};
/// # struct World(EnvSpec, u8);
/// # impl Env for World {
/// #     fn spec(&self) -> &EnvSpec { &self.0 }
/// #     fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
/// #         self.1 = 0; obs[0] = 0.0; Ok(())
/// #     }
/// #     fn step(&mut self, _: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
/// #         self.1 += 1; obs[0] = self.1.into(); reward[0] = 0.5;
/// #         Ok(if self.1 < 3 { Outcome::Running } else { Outcome::Truncated })
/// #     }
/// #     fn save(&self, state: &mut State) -> Result<()> { state.put("step", [self.1]); Ok(()) }
/// #     fn load(&mut self, state: &State) -> Result<()> {
/// #         self.1 = state.get_one("step")?; Ok(())
/// #     }
/// # }
/// # struct Still;
/// # impl Agent for Still {
/// #     fn seed(&self) -> u64 { 0 }
/// #     fn discount(&self) -> f64 { 0.9 }
/// #     fn act(&mut self, _: &[f32], _: Mode, action: &mut [f32]) -> Result<()> {
/// #         action.fill(0.0); Ok(())
/// #     }
/// #     fn value(&mut self, _: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
/// #         q.fill(1.25); Ok(())
/// #     }
/// #     fn save(&self, _: &mut State) -> Result<()> { Ok(()) }
/// #     fn load(&mut self, _: &State) -> Result<()> { Ok(()) }
/// # }
/// # let env = || World(EnvSpec::new("world", 1, 1).reward("time", 1.0).horizon(3), 0);
/// # let agent: Box<dyn Agent> = Box::new(Still);
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("first");
/// use copq::{Method, Trainer};
/// use copq_experiments::{Plan, Run, RunFolder, RunSettings, Sheet};
///
/// // In a world whose episodes return 1.5.
/// let method = Method::cop_td3();
/// let mut plan = Plan::new(&method);
/// plan.run = RunSettings { steps: 30, eval_every: 10, ..RunSettings::default() };
/// let folder = RunFolder::create(&path, &plan, &method.config)?;
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
    metrics: Metrics,
    evaluations: Evaluations,
    timings: Timings,
    events: EventFile,
    progress: Progress,
    best: Best,
    first_step: u64,
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
    /// Takes a fresh trainer, an environment of its own for evaluation (a second instance of the
    /// same task; without one, evaluation borrows the trainer's) and a folder; goes back to the
    /// folder's checkpoint if it has one.
    pub fn new(
        mut trainer: Trainer,
        eval_env: Option<Box<dyn Env>>,
        folder: RunFolder,
        settings: RunSettings,
    ) -> Result<Self> {
        settings.check()?;
        if let Some(eval_env) = &eval_env {
            check_same_task(&trainer, eval_env.as_ref())?;
        }
        // A checkpoint holds the world in mid-episode: better now than after the first steps.
        trainer.env().save(&mut State::default())?;
        check_same_seed(&trainer, &settings)?;
        let saved = folder.load()?;
        match &saved {
            Some(saved) => go_on(&mut trainer, &folder, saved)?,
            None => check_not_begun(&folder, &settings)?,
        }
        let step = trainer.steps();
        let table = |name: &str, every: u64| {
            // Off its interval, a row was the last one of a shorter run.
            let keep = |row: u64| row <= step && row.is_multiple_of(every);
            Table::open(&folder.file(name), rows_of(saved.as_ref(), name), keep)
        };
        let mut metrics = Metrics::of(table("metrics.csv", settings.log_every)?);
        if let Some(saved) = &saved {
            metrics.load(saved.child("metrics")?)?;
        }
        let evaluations = Evaluations::of(table("evaluations.csv", settings.eval_every)?);
        // A run from before there were policies' files begins to look for its best now.
        let has_best = folder.file("policy-best.safetensors").exists();
        let rows =
            if has_best { Sheet::read(&folder.file("evaluations.csv"))? } else { Sheet::default() };
        Ok(Self {
            metrics,
            evaluations,
            timings: Timings::of(table("timings.csv", settings.log_every)?, step),
            events: EventFile::create(folder.path(), step)?,
            progress: Progress::new(step, settings.steps, &folder.file("log.txt")),
            best: Best::of_rows(&rows, trainer.spec()),
            first_step: step,
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

    /// Trains to the last step, or until SIGINT, SIGTERM or SIGHUP asks to stop.
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
        let is_due = self.is_evaluation_due();
        if is_due {
            self.evaluate(&stop)?;
            // The checkpoint that was there knows nothing of its row.
            self.saved_step = None;
        }
        while self.trainer.steps() < self.settings.steps && !stop.is_asked() {
            self.step(&stop)?;
        }
        if self.saved_step != Some(self.trainer.steps()) {
            self.checkpoint()?;
        }
        let ending = self.close(&stop)?;
        if self.trainer.steps() > self.first_step {
            self.progress.line(&self.describe_time(began.elapsed()));
        } else if matches!(ending, Ending::Finished { .. }) && !is_due {
            let text = format!("nothing to do: the run has its {steps} steps; more with --steps");
            self.progress.line(&text);
        }
        self.progress.finish();
        Ok(ending)
    }

    fn step(&mut self, stop: &Stop) -> Result<()> {
        let episode = match self.trainer.step(&mut self.metrics) {
            Err(error) if self.trainer.world_failed() => return self.world_failed(error),
            stepped => stepped?,
        };
        self.env_errors_in_a_row = 0;
        let step = self.trainer.steps();
        self.progress.step(step);
        for warning in self.metrics.take_warnings() {
            self.progress.line(&warning);
        }
        if let Some(episode) = episode {
            let spec = self.trainer.spec();
            self.metrics.episode(step, &episode, spec);
            self.progress.episode(&episode, &spec.weights());
        }
        if step.is_multiple_of(self.settings.log_every) {
            self.log()?;
        }
        if self.is_evaluation_due() {
            self.evaluate(stop)?;
        }
        if step.is_multiple_of(self.settings.checkpoint_every) && !stop.is_asked() {
            self.checkpoint()?;
        }
        Ok(())
    }

    /// The episode is over where it was; the run ends here, saved, or goes on with the next one.
    fn world_failed(&mut self, error: Error) -> Result<()> {
        self.env_errors += 1;
        self.env_errors_in_a_row += 1;
        let step = self.trainer.steps();
        let episode = self.trainer.episode();
        if episode.length > 0 {
            self.metrics.episode(step, episode, self.trainer.spec());
        }
        let step = grouped(step);
        let goes_on = self.settings.on_env_error == OnEnvError::Reset;
        if goes_on && self.env_errors_in_a_row < PATIENCE {
            let text = format!("after step {step}: {error}; the episode counts as truncated");
            self.progress.line(&text);
            return Ok(());
        }
        self.checkpoint()?;
        let path = self.folder.path().display();
        let what = if goes_on {
            format!("the environment failed {PATIENCE} times in a row after step {step}")
        } else {
            format!(
                "the environment failed after step {step}, where the run is saved (copq resume \
                 {path} goes on with a new episode; --on-env-error reset does so by itself)"
            )
        };
        Err(Error::other(what, error))
    }

    fn log(&mut self) -> Result<()> {
        let step = self.trainer.steps();
        if self.env_errors > 0 {
            self.metrics.scalar(step, "env_errors", self.env_errors as f64);
        }
        let averages = self.metrics.row(step)?;
        let times = self.timings.row(step, self.trainer.timing())?;
        self.events.scalars(step, &averages)?;
        self.events.scalars(step, &times)
    }

    fn is_evaluation_due(&self) -> bool {
        let step = self.trainer.steps();
        self.settings.eval_every > 0
            && step.is_multiple_of(self.settings.eval_every)
            && self.evaluations.last() != Some(step)
    }

    /// Evaluates, unless a signal comes meanwhile; then the run that goes on does it.
    fn evaluate(&mut self, stop: &Stop) -> Result<()> {
        let began = Instant::now();
        let episodes = self.settings.eval_episodes;
        let evaluation = match &mut self.eval_env {
            None => self.trainer.evaluate(episodes),
            Some(env) => {
                evaluate(self.trainer.agent_mut(), Watched { env: env.as_mut(), stop }, episodes)
            }
        };
        let evaluation = match evaluation {
            Err(_) if stop.is_asked() => return Ok(()),
            Err(error) => return self.evaluation_failed(error),
            Ok(evaluation) => evaluation,
        };
        let step = self.trainer.steps();
        let spec = self.trainer.spec();
        // The row comes last: it says that the evaluation is done, and is not done again.
        let columns = evaluations::columns(&evaluation, spec);
        let is_best = self.best.update_by(&columns, spec);
        self.save_policy("policy.safetensors")?;
        if is_best {
            self.save_policy("policy-best.safetensors")?;
        }
        let spec = self.trainer.spec();
        let numbers = self.evaluations.row(step, &evaluation, spec)?;
        self.progress.line(&evaluations::describe(step, &evaluation, spec));
        self.events.scalars(step, &numbers)?;
        self.evaluation_time += began.elapsed();
        self.timings.evaluated(began.elapsed());
        // A run is worth more than its picture.
        if let Err(error) = figure::draw_run(self.folder.path(), self.trainer.spec()) {
            self.progress.line(&format!("the curves could not be drawn: {error}"));
        }
        Ok(())
    }

    /// A run is worth more than one of its evaluations, if it was told so.
    fn evaluation_failed(&mut self, error: Error) -> Result<()> {
        let what = format!("the evaluation after step {}", grouped(self.trainer.steps()));
        if self.settings.on_env_error == OnEnvError::Reset {
            self.progress.line(&format!("{what} failed: {error}"));
            return Ok(());
        }
        if self.saved_step != Some(self.trainer.steps()) {
            self.checkpoint()?;
        }
        let what = format!(
            "{what}, where the run is saved (--on-env-error reset goes on without the row)"
        );
        Err(Error::other(what, error))
    }

    /// Writes the policy by itself, if the agent has one to write.
    fn save_policy(&self, name: &str) -> Result<()> {
        match self.trainer.agent().save_policy(&self.folder.file(name)) {
            Err(Error::Unsupported { .. }) => Ok(()),
            saved => saved,
        }
    }

    fn checkpoint(&mut self) -> Result<()> {
        // Rows must be as durable as the checkpoint that will not write them again.
        self.metrics.sync()?;
        self.evaluations.sync()?;
        self.timings.sync()?;
        let mut state = State::default();
        self.trainer.save(state.child_mut("trainer"))?;
        self.metrics.save(state.child_mut("metrics"));
        let rows = state.child_mut("rows");
        rows.put("metrics.csv", [self.metrics.rows(self.settings.log_every)]);
        rows.put("evaluations.csv", [self.evaluations.rows(self.settings.eval_every)]);
        rows.put("timings.csv", [self.timings.rows(self.settings.log_every)]);
        state.put("env_errors", [self.env_errors]);
        if self.settings.replay == SavedReplay::None {
            remove_replay(&mut state);
        }
        self.folder.save(&state)?;
        self.saved_step = Some(self.trainer.steps());
        self.save_policy("policy.safetensors")
    }

    /// Writes the last rows, which a longer run would not have; the checkpoint knows nothing of
    /// them.
    fn close(&mut self, stop: &Stop) -> Result<Ending> {
        let step = self.trainer.steps();
        let folder = self.folder.path().to_owned();
        if step < self.settings.steps {
            return Ok(Ending::Interrupted { step, folder });
        }
        if self.metrics.last() != Some(step) {
            self.log()?;
        }
        if self.settings.eval_every > 0 && self.evaluations.last() != Some(step) {
            self.evaluate(stop)?;
        }
        let is_evaluated = self.settings.eval_every == 0 || self.evaluations.last() == Some(step);
        if stop.is_asked() && !is_evaluated {
            return Ok(Ending::Interrupted { step, folder });
        }
        Ok(Ending::Finished { folder })
    }

    fn describe_time(&self, total: Duration) -> String {
        let steps = self.trainer.steps() - self.first_step;
        timings::describe(steps, total, self.trainer.timing(), self.evaluation_time)
    }
}

/// How many rows of a table must be there, by the checkpoint; older ones do not say.
fn rows_of(saved: Option<&State>, name: &str) -> u64 {
    let rows = saved.and_then(|saved| saved.child("rows").ok());
    rows.and_then(|rows| rows.get_one(name).ok()).unwrap_or(0)
}

fn go_on(trainer: &mut Trainer, folder: &RunFolder, saved: &State) -> Result<()> {
    let loaded = saved.child("trainer").and_then(|saved| trainer.load(saved));
    loaded.map_err(|e| {
        let file = folder.file("checkpoint.safetensors");
        Error::other(format!("going on from '{}'", file.display()), e)
    })
}

fn check_same_seed(trainer: &Trainer, settings: &RunSettings) -> Result<()> {
    let seed = trainer.agent().seed();
    if seed == settings.seed {
        return Ok(());
    }
    Err(Error::invalid("the agent's seed", format!("the run's, {}", settings.seed), seed))
}

/// An error for a folder that has lost its checkpoint: to begin anew would delete what it has left.
fn check_not_begun(folder: &RunFolder, settings: &RunSettings) -> Result<()> {
    let mut last = None;
    for name in ["evaluations.csv", "metrics.csv"] {
        let file = folder.file(name);
        if file.exists() {
            last = last.max(Sheet::read(&file)?.steps().last().copied());
        }
    }
    match last {
        Some(step) if step > settings.checkpoint_every => {
            let what = format!("run folder '{}'", folder.path().display());
            let wanted = "its checkpoint.safetensors, to go on from (the command in config.toml, \
                 with a new --out, repeats the run)";
            Err(Error::invalid(
                what,
                wanted,
                format!("none, but rows up to step {}", grouped(step)),
            ))
        }
        _ => Ok(()),
    }
}

fn check_same_task(trainer: &Trainer, eval_env: &dyn Env) -> Result<()> {
    trainer.spec().check_same("environment for evaluation", eval_env.spec())
}
