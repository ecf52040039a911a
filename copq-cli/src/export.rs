//! `copq export`: a policy without its run.

use std::path::{Path, PathBuf};

use copq::{Error, Policy, Result, files};
use copq_candle::Candle;
use copq_envs_python::is_task;
use copq_experiments::{read_policy, write_onnx};

use crate::options::{not_of_a_run, say};
use crate::saved::{Learned, newest_policy};

/// Writes a run's policy to one small file: network, normaliser, action bounds, but no replay.
///
/// The policy of a run's folder is the last one; policy-best.safetensors in it is the best one.
///
/// copq::Policy and Python can read safetensors back. ONNX needs no copq: raw observations in, the
/// environment's own actions out.
#[derive(clap::Args)]
pub struct Export {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0; or a policy file, such as its
    /// policy-best.safetensors.
    run: PathBuf,

    /// Format of the file. [default: from the extension of --out, or safetensors]
    #[arg(long, value_name = "NAME")]
    format: Option<Format>,

    /// File to write. [default: policy.safetensors or policy.onnx in the run's folder; for a policy
    /// file, beside it under its name]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Safetensors,
    Onnx,
}

impl Format {
    /// The extension of its files.
    fn extension(self) -> &'static str {
        match self {
            Self::Safetensors => "safetensors",
            Self::Onnx => "onnx",
        }
    }

    /// The format of a file's extension, if it is one.
    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_ascii_lowercase();
        [Self::Safetensors, Self::Onnx].into_iter().find(|format| extension == format.extension())
    }
}

impl Export {
    pub fn run(self) -> anyhow::Result<()> {
        let format = self.format()?;
        let out = self.out(format)?;
        let policy = self.policy()?;
        files::replace_shared(&out, |part| match format {
            Format::Safetensors => policy.write(part),
            Format::Onnx => write_onnx(&policy, part),
        })?;
        Ok(say(&format!("the policy is in {}\n", out.display()))?)
    }

    /// The format asked for, in words or by the file's name; an error if they differ.
    fn format(&self) -> Result<Format> {
        let named = self.out.as_deref().and_then(Format::of);
        let format = self.format.or(named).unwrap_or(Format::Safetensors);
        if named.is_some_and(|named| named != format) {
            let what = format!("--format {}", format.extension());
            let wanted = format!("an --out that ends in .{}", format.extension());
            let got = self.out.as_deref().map_or(String::new(), |out| out.display().to_string());
            return Err(Error::invalid(what, wanted, got));
        }
        Ok(format)
    }

    /// The file to write; an error for the one that is read, and for a run's other files.
    fn out(&self, format: Format) -> Result<PathBuf> {
        let is_file = self.run.is_file();
        let usual = if is_file {
            self.run.with_extension(format.extension())
        } else {
            self.run.join("policy").with_extension(format.extension())
        };
        let is_usual = self.out.is_none();
        let out = self.out.clone().unwrap_or(usual);
        // A policy file may lie among a run's own files.
        if is_file && (out == self.run || is_usual && out.exists()) {
            let what = format!("'{}'", out.display());
            return Err(Error::invalid(what, "a new file (--out)", "one that exists"));
        }
        if out.file_stem().is_none_or(|name| name != "policy") {
            not_of_a_run(&out)?;
        }
        Ok(out)
    }

    fn policy(&self) -> Result<Policy> {
        if self.run.is_file() {
            return Policy::from_state(&read_policy(&self.run)?, &Candle::default());
        }
        let learned = Learned::read(&self.run)?;
        // No environment is needed for it; a Python environment may be missing.
        let file = self.run.join("policy.safetensors");
        let of_python = is_task(&learned.plan.task) && file.is_file();
        if let Some(file) = newest_policy(&self.run).or(of_python.then_some(file)) {
            return Policy::from_state(&read_policy(file)?, &Candle::default());
        }
        learned.policy(false, learned.env()?.spec())
    }
}
