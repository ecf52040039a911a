//! A run's folder, read again: its method, world and policy.

use std::path::{Path, PathBuf};

use copq::projection::{self, Cholesky};
use copq::{Config, EnvSpec, Error, Method, Policy};
use copq_candle::Candle;
use copq_experiments::{Plan, RunConfig, read_checkpoint, read_config};

/// What the run in a folder was made with.
pub fn config(folder: &Path) -> copq::Result<RunConfig<Config>> {
    read_config(folder)
}

/// The method of a run.
pub fn method(plan: &Plan, settings: Config) -> copq::Result<Method> {
    let method = Method::by_name(&plan.method).map_err(|_| {
        let got = format!("one of '{}', which another program trains", plan.method);
        Error::invalid("the run", "one of copq's own methods (copq methods)", got)
    })?;
    let mut method = if plan.bound == method.bound.name() {
        method
    } else {
        method.bound(projection::by_name(&plan.bound)?)
    };
    method.critics = plan.critics;
    method.config = settings;
    Ok(method)
}

/// A run's own copy of the policy that it began with.
pub const INIT: &str = "policy-init.safetensors";

/// What a run that has no checkpoint yet begins with, if that is a policy: its copy, or what it was
/// made from if it was killed before there was one.
pub fn init(folder: &Path, plan: &Plan) -> copq::Result<Option<PathBuf>> {
    let copy = folder.join(INIT);
    if folder.join("checkpoint.safetensors").is_file() {
        return Ok(None);
    }
    match &plan.init_from {
        None => Ok(None),
        Some(_) if copy.is_file() => Ok(Some(copy)),
        Some(from) => policy_file(from).map(Some),
    }
}

/// The policy's file of a run's folder, the best one if there is one; or the file itself.
pub fn policy_file(path: &Path) -> copq::Result<PathBuf> {
    if path.is_file() {
        return Ok(path.to_owned());
    }
    let names = ["policy-best.safetensors", "policy.safetensors"];
    let files = names.map(|name| path.join(name));
    files.into_iter().find(|file| file.is_file()).ok_or_else(|| {
        let wanted = "a policy's file, or a run's folder with one (copq export writes it for \
             older runs)";
        Error::invalid(format!("'{}'", path.display()), wanted, "neither")
    })
}

/// What the run in a folder has learned so far.
pub fn policy(
    folder: &Path,
    plan: &Plan,
    settings: Config,
    spec: &EnvSpec,
) -> copq::Result<Policy> {
    let checkpoint = read_checkpoint(folder)?;
    let agent = checkpoint.child("trainer")?.child("agent")?;
    // A policy needs no bound and no critics, so that runs of other programs' methods have one,
    // too.
    Policy::load(&Method::new(&plan.method, settings, Cholesky), spec, &Candle::default(), agent)
}
