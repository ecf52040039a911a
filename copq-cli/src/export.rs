//! `copq export`: a policy without its run.

use std::path::PathBuf;

use crate::options::say;
use crate::saved::Learned;

/// Writes what a run has learned to one small safetensors file, without the replay: network,
/// normaliser, action bounds.
///
/// copq::Policy reads it back; so does Python.
#[derive(clap::Args)]
pub struct Export {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// The file to write. [default: policy.safetensors in the run's folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Export {
    pub fn run(self) -> anyhow::Result<()> {
        let learned = Learned::read(&self.run)?;
        let policy = learned.policy(&self.run, learned.env()?.spec())?;
        let out = self.out.unwrap_or_else(|| self.run.join("policy.safetensors"));
        policy.write(&out)?;
        Ok(say(&format!("the policy is in {}\n", out.display()))?)
    }
}
