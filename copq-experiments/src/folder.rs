//! A run's folder: made once, never overwritten, written by one process at a time.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use copq::{Error, Result, State};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::checkpoints::Checkpoints;
use crate::config::{self, MadeWith, RunConfig};
use crate::ending::resume_command;
use crate::fingerprint::fingerprint;
use crate::lock::{LOCK, check_held, lock};
use crate::origin::Origin;
use crate::plan::Plan;
use crate::standing::complaint_file;
use copq::files;

/// The folder that a run leaves behind.
///
/// | file | content |
/// |---|---|
/// | `config.toml` | everything needed to repeat the run |
/// | `metrics.csv` | averages over each logging interval: training episodes, losses, Q-values |
/// | `evaluations.csv` | returns of the evaluation episodes, expected and observed values |
/// | `timings.csv` | where the time went |
/// | `events.out.tfevents.*` | the means of these numbers for TensorBoard |
/// | `curve.svg`, `curve.png` | the evaluations as a picture |
/// | `policy.safetensors` | the policy of the last evaluation or checkpoint ([`copq::Policy`]) |
/// | `policy-best.safetensors` | the policy of the best evaluation: costs within their limits come first, then the weighted total |
/// | `policy-best-before.safetensors` | the best policy of evaluations whose rows were dropped when the run went back to its checkpoint |
/// | `checkpoint.safetensors` | everything needed to resume the run |
/// | `checkpoint.1.safetensors` | the checkpoint before that; [`RunSettings::keep`](crate::RunSettings) says how many there are |
/// | `checkpoint.later.safetensors` | the last checkpoint, if the run has gone back to the one before ([`RunFolder::go_back`]) |
/// | `checkpoint.damaged.safetensors` | the same, if the checkpoint did not read back well |
/// | `log.txt` | what the run printed on the screen |
/// | `DONE` | written last, when all steps are done: the run's [`fingerprint`](crate::fingerprint()) |
///
/// Columns of `metrics.csv`, where NAME is an objective's. All but the first four come from the
/// updates' batches:
///
/// | column | meaning |
/// |---|---|
/// | `train/length` | steps of the episodes that ended, with exploration |
/// | `train/return/NAME` | their undiscounted returns |
/// | `train/weighted_total` | the sum of these returns, weighted by the task's weights |
/// | `env_errors` | how often the environment has failed since the run began ([`OnEnvError::Reset`](crate::OnEnvError)); written from the first failure on |
/// | `q/NAME` | the critics' mean value of the replayed actions (discounted, like all values) |
/// | `q_std/NAME` | the critics' standard deviation there (the root of its mean square over the batch) |
/// | `correlation/A/B` | the correlation of the critics' disagreements about two objectives there, from -1 to 1 (only for critics of all objectives) |
/// | `bound/NAME` | the lower bound there, by the learner's projection |
/// | `target/NAME` | what the critics are trained towards: mean TD target |
/// | `critic_loss/NAME` | mean squared distance from it, over critics and batch |
/// | `pessimism/target` | how far the bound lies below the mean of its critics, at the targets' next actions: weights x (mean - bound), with the actor's weights; over all rows, including those that terminate and CAL's own cost targets |
/// | `pessimism/actor` | the same at the policy's own actions, where the actor maximises the bound |
/// | `clip_rate` | share of the targets in which the Cholesky bound was clipped |
/// | `q_rounding` | with `networks.precision = "careful"`, every 1,000 updates: how much 16 bits blur the critics' values, in units of the critics' standard deviation; for the most blurred objective |
/// | `famo/NAME` | FAMO's weight of the objective's loss; the weights sum to 1 |
/// | `actor/objective` | what the actor maximises, without the entropy bonus: weights x bound (in REDQ: x mean) of its own actions |
/// | `actor/entropy` | entropy of a stochastic policy, in nats of actions in \[-1, 1\] |
/// | `actor/temperature` | alpha, the entropy bonus's weight |
/// | `multiplier/NAME` | lambda of a cost, as projections use it |
/// | `multiplier_effective/NAME` | the cost's weight in `actor/objective`: that of the augmented Lagrangian |
/// | `cost_estimate/NAME` | the pessimistic cost of the replayed actions, discounted |
/// | `cost_violation/NAME` | how far that is above the discounted limit |
///
/// For on-policy methods, once per epoch; SIGNAL is `reward` or a cost's name:
///
/// | column | meaning |
/// |---|---|
/// | `policy/kl`, `policy/passes` | KL(old \|\| new) after the last pass (or the natural step), summed over action components; number of passes done |
/// | `policy/second_kl`, `policy/second_passes` | the same for CUP's second step, from where the first step ended |
/// | `policy/clip_share` | share of the rows whose ratio was clipped in the last pass (clipped steps only) |
/// | `policy/entropy`, `policy/std` | mean over action components of the Gaussian's entropy and standard deviation |
/// | `policy/lr` | the policy's step size (clipped steps only) |
/// | `critic_loss/SIGNAL` | mean squared distance from the targets in the last pass |
/// | `explained_variance/SIGNAL` | share of the targets' variance that the critic had predicted before it was trained on them |
/// | `advantage_std/SIGNAL` | standard deviation of the advantages, in the signal's unit |
/// | `multiplier/NAME` | lambda of a cost |
/// | `cost_window/NAME`, `cost_epoch/NAME` | mean undiscounted cost of the episodes that the multiplier sees, and of those that ended in this epoch |
///
/// `evaluations.csv` has `episodes`, then the mean, standard deviation, smallest and largest of
/// their returns (`weighted_total/mean`, `/std`, `/min`, `/max`, `return/NAME/mean` and so on),
/// `length/mean`, `q_start/NAME` (the critics' mean value of an episode's first action: the value
/// of the policy that they learn, so with smoothing noise, or with samples and their entropy bonus)
/// and `discounted/NAME` (what the episode then returned, discounted).
///
/// A crash at any moment leaves a folder that can be resumed. The CSV files only grow, and lose a
/// torn last line on resume; the other files are replaced by a rename.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("first");
/// use copq::{Method, State};
/// use copq_experiments::{Plan, RunFolder};
///
/// let method = Method::cop_td3();
/// let plan = Plan::new(&method);
/// let folder = RunFolder::create(&path, &plan, &method.config)?;
/// assert!(folder.file("config.toml").exists() && folder.load()?.is_none());
/// folder.save(&State::default())?;
/// drop(folder); // one process at a time writes to it
///
/// assert!(RunFolder::create(&path, &plan, &method.config).is_err()); // it is there already
/// assert!(RunFolder::resume(&path, &plan, &method.config)?.load()?.is_some());
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    checkpoints: Checkpoints,
    fingerprint: String,
    /// The plan and settings that make its steps.
    pub(crate) origin: Origin,
    /// The new configuration of a run that resumes, if it changes.
    changed: Option<String>,
    /// It has had a checkpoint after this many steps, whoever began it.
    pub(crate) first_checkpoint: u64,
    // Held for as long as the run writes; the system releases it when the process ends, however it
    // ends.
    _lock: File,
}

impl RunFolder {
    /// Makes the folder with its `config.toml`, or uses an empty one. An error if the folder
    /// already contains anything.
    pub fn create<S: Serialize>(
        path: impl Into<PathBuf>,
        plan: &Plan,
        settings: &S,
    ) -> Result<Self> {
        let path = path.into();
        plan.check()?;
        let made_with = MadeWith::here();
        let config = config::encode(&RunConfig { plan: plan.clone(), settings, made_with })?;
        if is_taken(&path) {
            return Err(taken(&path));
        }
        let is_new = !path.exists();
        fs::create_dir_all(&path).map_err(files::failed("making", &path))?;
        let fingerprint = fingerprint(plan, settings)?;
        let origin = Origin::new(plan, settings)?;
        let _lock = begin(&path, &config, is_new)?;
        let checkpoints = Checkpoints::new(&path, &plan.run);
        let first_checkpoint = plan.run.checkpoint_every;
        Ok(Self { path, checkpoints, fingerprint, origin, changed: None, first_checkpoint, _lock })
    }

    /// Reopens a folder to resume its run.
    ///
    /// Nothing in it changes before [`RunFolder::take_up`], which a [`Run`](crate::Run) calls once
    /// everything has proved to fit.
    ///
    /// Errors: no run there, another process writes to it, settings or a plan that differ from the
    /// saved ones. Only the steps may increase, and what changes no number, such as the threads,
    /// may differ.
    pub fn resume<S: Serialize + DeserializeOwned>(
        path: impl Into<PathBuf>,
        plan: &Plan,
        settings: &S,
    ) -> Result<Self> {
        let path = path.into();
        read_config::<toml::Table>(&path)?;
        let checkpoints = Checkpoints::new(&path, &plan.run);
        let fingerprint = fingerprint(plan, settings)?;
        let origin = Origin::new(plan, settings)?;
        let _lock = lock(&path)?;
        let file = path.join("config.toml");
        let mut saved: RunConfig<S> = config::read(&file)?;
        let first_checkpoint = saved.plan.run.checkpoint_every.max(plan.run.checkpoint_every);
        let mut folder =
            Self { path, checkpoints, fingerprint, origin, changed: None, first_checkpoint, _lock };
        config::check_same(&file, "settings", &saved.settings, settings)?;
        check_plan(&folder.path, &saved.plan, plan)?;
        folder.check_not_lost()?;
        if *plan != saved.plan {
            saved.plan = plan.clone();
            folder.changed = Some(config::encode(&saved)?);
        }
        Ok(folder)
    }

    /// Takes up a run that [`RunFolder::resume`] has checked. Its configuration now says what is
    /// wanted, it is neither done nor failed, and if it goes back, its checkpoint is the one
    /// before. Only for programs that train without a [`Run`](crate::Run).
    pub fn take_up(&mut self) -> Result<()> {
        self.checkpoints.take_up()?;
        if let Some(config) = self.changed.take() {
            files::replace(&self.file("config.toml"), config.as_bytes())?;
        }
        // The report of an earlier failure is no longer true.
        fs::remove_file(complaint_file(&self.path)).unwrap_or_default();
        // Its last rows may be written again.
        match fs::remove_file(self.file(DONE)) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(files::failed("removing", &self.file(DONE))(error))
            }
            _ => Ok(()),
        }
    }

    /// An error for a run that is done but has lost its checkpoint: it would start again, over its
    /// own results.
    fn check_not_lost(&self) -> Result<()> {
        if self.file(DONE).exists() && matches!(self.load(), Ok(None)) {
            let what = format!("run folder '{}'", self.path.display());
            let wanted = "the checkpoint of the finished run (for a similar run in a new folder: \
                          copq train --like)";
            return Err(Error::invalid(what, wanted, "none"));
        }
        Ok(())
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of a file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Replaces the checkpoint; the new one is read back before it takes its place. Older ones
    /// become `checkpoint.1.safetensors` and so on. An error if another run has the folder now.
    pub fn save(&self, state: &State) -> Result<()> {
        self.check_held()?;
        self.checkpoints.save(state)
    }

    /// The last checkpoint, or the one before it ([`RunFolder::go_back`]); none if the run was
    /// stopped before the first. The error for a damaged or lost one says whether there is one
    /// before it.
    pub fn load(&self) -> Result<Option<State>> {
        self.checkpoints.load()
    }

    /// Marks the run as done, by writing the file `DONE` with the run's
    /// [`fingerprint`](crate::fingerprint()).
    pub(crate) fn finish(&self) -> Result<()> {
        self.check_held()?;
        files::replace(&self.file(DONE), format!("{}\n", self.fingerprint).as_bytes())
    }

    /// An error if this is no longer the folder that was taken: it may have been moved or deleted,
    /// and another run may have a folder of its name.
    pub(crate) fn check_held(&self) -> Result<()> {
        check_held(&self.path)
    }

    /// Goes back to the newest sound checkpoint before the last one, as soon as the run is taken up
    /// ([`RunFolder::take_up`]; until then, files move only to finish what a kill left half done).
    /// Returns whether the last one reads back well. It is kept: as `checkpoint.later.safetensors`
    /// if it does, or else as `checkpoint.damaged.safetensors`, with a number added if such a file
    /// exists.
    pub fn go_back(&mut self) -> Result<bool> {
        self.checkpoints.go_back()
    }

    /// The checkpoint's file that [`RunFolder::load`] reads.
    pub(crate) fn start(&self) -> PathBuf {
        self.checkpoints.start()
    }
}

/// The [`fingerprint`](crate::fingerprint()) of the run in a folder, if it has all its steps.
pub fn read_done(path: &Path) -> Option<String> {
    Some(fs::read_to_string(path.join(DONE)).ok()?.trim().to_owned())
}

/// The plan of the run in a folder.
pub fn read_plan(path: &Path) -> Result<Plan> {
    Ok(read_config::<toml::Table>(path)?.plan)
}

/// The whole configuration of the run in a folder.
pub fn read_config<S: DeserializeOwned>(path: &Path) -> Result<RunConfig<S>> {
    let file = path.join("config.toml");
    if !file.is_file() {
        let what = format!("run folder '{}'", path.display());
        let got = if path.exists() { "one without config.toml" } else { "nothing of that name" };
        return Err(Error::invalid(what, "the folder of a run", got));
    }
    config::read(&file)
}

/// Written last by a run that has all its steps.
const DONE: &str = "DONE";

/// Whether a path holds anything except what a killed start or a new disk leaves.
fn is_taken(path: &Path) -> bool {
    let of_nobody = [LOCK, ".config.toml.part", "lost+found"];
    match fs::read_dir(path) {
        Ok(entries) => entries.into_iter().any(|entry| {
            entry.is_ok_and(|entry| !of_nobody.iter().any(|n| entry.file_name() == *n))
        }),
        Err(_) => path.exists(),
    }
}

/// Makes an empty folder a run's, with its lock and its configuration. If that fails, a folder that
/// was made for it is removed.
fn begin(path: &Path, config: &str, is_new: bool) -> Result<File> {
    let lock = lock(path)?;
    // Another process may have begun since the first check.
    if is_taken(path) {
        return Err(taken(path));
    }
    let written = files::replace(&path.join("config.toml"), config.as_bytes());
    if written.is_err() {
        fs::remove_file(path.join("config.toml")).unwrap_or_default();
    }
    if written.is_err() && is_new {
        // The first failure says more than that an empty folder was left.
        fs::remove_file(path.join(LOCK)).unwrap_or_default();
        fs::remove_dir(path).unwrap_or_default();
    }
    written?;
    // So that the folder itself survives a power failure; we may have no access to its parent.
    files::sync_folder_of(path).unwrap_or_default();
    Ok(lock)
}

fn taken(path: &Path) -> Error {
    let shown = path.display();
    let wanted = if path.join("config.toml").is_file() {
        let command = resume_command(path);
        format!("a new folder (resume this run with {command}, or choose another --out)")
    } else {
        "a new folder (choose another --out)".to_owned()
    };
    Error::invalid(format!("run folder '{shown}'"), wanted, "one that already exists")
}

fn check_plan(path: &Path, saved: &Plan, now: &Plan) -> Result<()> {
    now.check()?;
    if now.run.steps < saved.run.steps {
        let what = format!("steps of the run in '{}'", path.display());
        return Err(Error::invalid(
            what,
            format!("at least the planned {}", saved.run.steps),
            now.run.steps,
        ));
    }
    let file = path.join("config.toml");
    config::check_same(&file, "plan", &saved.without_length(), &now.without_length())
}
