//! How long a run is, how often it does what, and what it keeps.

use copq::{Error, Result};
use serde::{Deserialize, Serialize};

/// More checkpoints than anybody looks at.
pub(crate) const MAX_KEEP: usize = 100;

/// How long a run is and how often it does what; everything is counted in environment steps.
///
/// ```
/// use copq_experiments::RunSettings;
///
/// let short = RunSettings { steps: 2_000, eval_every: 500, ..RunSettings::default() };
/// short.check()?;
/// let without_log = RunSettings { log_every: 0, ..short };
/// let error = without_log.check().unwrap_err();
/// assert_eq!(error.to_string(), "log-every: wanted at least 1, got 0");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RunSettings {
    /// Environment steps of training.
    pub steps: u64,
    /// Seed of every random number: networks, exploration, batches, episodes.
    pub seed: u64,
    /// Steps between two evaluations; 0 means never. There is also one at step 0, and one at the
    /// end.
    pub eval_every: u64,
    /// Episodes of an evaluation, the same ones every time.
    pub eval_episodes: usize,
    /// Steps that a row of `metrics.csv` averages over.
    pub log_every: u64,
    /// Steps between two checkpoints.
    pub checkpoint_every: u64,
    /// Checkpoints that are kept, including the newest.
    pub keep: usize,
    /// Which checkpoints hold the replay, which is most of their size.
    pub replay: SavedReplay,
    /// What to do when the environment fails.
    pub on_env_error: OnEnvError,
    /// What happens to the episode in progress when the run stops.
    #[serde(skip_serializing_if = "is_exact")]
    pub on_resume: OnResume,
}

/// Where a run resumes.
///
/// ```
/// use copq_experiments::{OnEnvError, OnResume, RunSettings, SavedReplay};
///
/// // For a simulator that fails now and then and cannot be saved, and a small disk.
/// let settings = RunSettings {
///     on_resume: OnResume::NewEpisode,
///     on_env_error: OnEnvError::Reset,
///     replay: SavedReplay::Last,
///     ..RunSettings::default()
/// };
/// let text = toml::to_string(&settings)?; // as config.toml has it
/// assert!(text.contains("replay = \"last\"\non_env_error = \"reset\"\n"));
/// assert!(text.ends_with("on_resume = \"new_episode\"\n"));
/// # Ok::<(), toml::ser::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum OnResume {
    /// In the middle of the episode: a run that stopped equals, bit for bit, one that did not.
    #[default]
    SameEpisode,
    /// With a new episode, for environments that cannot be saved; networks, replay, random numbers
    /// and everything else continue where they were. A run that stopped is then as good as one that
    /// did not, but not the same.
    NewEpisode,
}

/// Which checkpoints hold the replay; there is an example at [`OnResume`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SavedReplay {
    /// None. A resumed run is not what it would have been: it first gathers as much new experience
    /// as before its first update, with its current policy, and then continues to learn.
    None,
    /// The newest; from an older one, a run resumes as with `None`.
    Last,
    /// All: a run resumes from each bit for bit.
    #[default]
    All,
}

/// What a run does when its environment fails, as an unstable simulation can; there is an example
/// at [`OnResume`].
///
/// Either way the episode counts as truncated at its last good step, and the run can continue with
/// a new one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum OnEnvError {
    /// Save, and end with the error.
    #[default]
    Stop,
    /// Report it, count it in `metrics.csv` (`env_errors`), and begin the next episode.
    Reset,
}

// As serde calls it.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_exact(on_resume: &OnResume) -> bool {
    *on_resume == OnResume::SameEpisode
}

impl Default for RunSettings {
    /// 110,000 steps, after which the default's hopper stands (the median of five seeds), and the
    /// cadence of the literature: 10 episodes every 5,000 steps.
    fn default() -> Self {
        Self {
            steps: 110_000,
            seed: 0,
            eval_every: 5_000,
            eval_episodes: 10,
            log_every: 1_000,
            checkpoint_every: 20_000,
            keep: 2,
            replay: SavedReplay::All,
            on_env_error: OnEnvError::Stop,
            on_resume: OnResume::SameEpisode,
        }
    }
}

impl RunSettings {
    /// An error that names the first setting that cannot be used.
    pub fn check(&self) -> Result<()> {
        let counts = [
            ("steps", self.steps),
            ("eval-episodes", self.eval_episodes as u64),
            ("log-every", self.log_every),
            ("checkpoint-every", self.checkpoint_every),
        ];
        if !(1..=MAX_KEEP).contains(&self.keep) {
            return Err(Error::invalid("keep", format!("1 to {MAX_KEEP}"), self.keep));
        }
        if let Some((name, _)) = counts.iter().find(|(_, count)| *count == 0) {
            return Err(Error::invalid(*name, "at least 1", 0));
        }
        Ok(())
    }
}
