//! The options that may change when a run is resumed: they change no bit of what it learns.

use copq_experiments::{OnEnvError, Plan, SavedReplay};

use crate::options::count;

/// What copq train and copq resume share.
#[derive(clap::Args)]
pub struct Keeping {
    /// Number of checkpoints to keep, including the newest; copq resume --previous continues from
    /// the one before it. [default: 2; for a resumed run, its own]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    keep: Option<usize>,

    /// Which checkpoints hold the replay, most of their size: all, last or none. [default: all; for
    /// a resumed run, its own]
    ///
    /// From a checkpoint with the replay, a run continues bit for bit. From one without, it first
    /// gathers as much new experience as before its first update.
    #[arg(long, value_name = "WHICH", value_parser = saved_replay)]
    replay: Option<SavedReplay>,

    /// What to do when the environment fails, as an unstable simulation can: stop (save and stop)
    /// or reset (count the episode as truncated, reset and continue). [default: stop; for a resumed
    /// run, its own]
    #[arg(long, value_name = "WHAT", value_parser = on_env_error)]
    on_env_error: Option<OnEnvError>,

    /// Number of threads inside this run. [default: 1; for a resumed run, its own]
    ///
    /// They change no bit of the result. Several seeds run best as processes of one thread each.
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    threads: Option<usize>,
}

impl Keeping {
    /// The plan with the options applied.
    pub fn over(&self, plan: &mut Plan) {
        let run = &mut plan.run;
        run.keep = self.keep.unwrap_or(run.keep);
        run.replay = self.replay.unwrap_or(run.replay);
        run.on_env_error = self.on_env_error.unwrap_or(run.on_env_error);
        plan.threads = self.threads.unwrap_or(plan.threads);
    }
}

fn saved_replay(text: &str) -> Result<SavedReplay, String> {
    match text {
        "all" => Ok(SavedReplay::All),
        "last" => Ok(SavedReplay::Last),
        "none" => Ok(SavedReplay::None),
        _ => Err("wanted all, last or none".to_owned()),
    }
}

fn on_env_error(text: &str) -> Result<OnEnvError, String> {
    match text {
        "stop" => Ok(OnEnvError::Stop),
        "reset" => Ok(OnEnvError::Reset),
        _ => Err("wanted stop or reset".to_owned()),
    }
}
