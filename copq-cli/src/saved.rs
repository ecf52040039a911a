//! A run's folder, read again: its method, world and policy.

use std::path::Path;

use copq::{Config, EnvSpec, Method, Policy, projection};
use copq_candle::Candle;
use copq_experiments::{Plan, RunConfig, read_checkpoint, read_config};

/// What the run in a folder was made with.
pub fn config(folder: &Path) -> copq::Result<RunConfig<Config>> {
    read_config(folder)
}

/// The method of a run.
pub fn method(plan: &Plan, settings: Config) -> copq::Result<Method> {
    let method = Method::by_name(&plan.method)?;
    let mut method =
        if plan.bound == method.bound.name() { method } else { method.bound(projection::by_name(&plan.bound)?) };
    method.critics = plan.critics;
    method.config = settings;
    Ok(method)
}

/// What the run in a folder has learned so far.
pub fn policy(folder: &Path, plan: &Plan, settings: Config, spec: &EnvSpec) -> copq::Result<Policy> {
    let checkpoint = read_checkpoint(folder)?;
    let agent = checkpoint.child("trainer")?.child("agent")?;
    Policy::load(&method(plan, settings)?, spec, &Candle::default(), agent)
}
