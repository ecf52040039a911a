//! The options by which a run may change when it goes on: they change no bit of what it learns.

use copq_experiments::{OnEnvError, Plan, SavedReplay};

use crate::options::count;

/// What copq train and copq resume share.
#[derive(clap::Args)]
pub struct Keeping {
    /// Checkpoints that stay, the newest among them; copq resume --previous goes on from the one
    /// before. [default: 2; of a resumed run its own]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    keep: Option<usize>,

    /// Which checkpoints hold the replay, most of their size: all, last or none. [default: all; of
    /// a resumed run its own]
    ///
    /// A run goes on bit for bit from a checkpoint with it. From one without, it first gathers as
    /// much experience anew as before its first update.
    #[arg(long, value_name = "WHICH", value_parser = saved_replay)]
    replay: Option<SavedReplay>,

    /// What to do when the environment fails, as an unstable simulation can: save and stop, or
    /// count the episode as truncated, reset and go on. [default: stop; of a resumed run its own]
    #[arg(long, value_name = "WHAT", value_parser = on_env_error)]
    on_env_error: Option<OnEnvError>,

    /// Threads inside this run. [default: 1; of a resumed run its own]
    ///
    /// They change no bit of the result. Seeds run best as processes of one thread each.
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    threads: Option<usize>,
}

impl Keeping {
    /// The plan with the options over it.
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
