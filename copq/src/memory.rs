//! Whether what a configuration needs fits into this machine's memory, before it is allocated.

use crate::{Config, EnvSpec, Error, Result, on_policy};

/// Copies of a network's parameters: online, target, and Adam's two moments.
const COPIES: f64 = 4.0;
/// Copies of a batch's activations: forward, backward, and room to lay them out.
const ACTIVATIONS: f64 = 3.0;

/// An error for networks or batches that this machine cannot hold.
pub(crate) fn check(config: &Config, spec: &EnvSpec, critics: usize) -> Result<()> {
    let networks = critics as f64 + 1.0;
    let parameters = networks * COPIES * parameters(config, spec) * size_of::<f32>() as f64;
    let batch = networks * ACTIVATIONS * config.batch as f64 * widths(config, spec) * 4.0;
    fits("networks.hidden", parameters, format!("{:?}", config.networks.hidden))?;
    fits("batch", batch, config.batch.to_string())
}

/// The same for on-policy learning: networks, and the rows of an epoch.
pub(crate) fn check_on_policy(
    config: &on_policy::Config,
    spec: &EnvSpec,
    signals: usize,
) -> Result<()> {
    let hidden = &config.networks.hidden;
    let widths = std::iter::once(&spec.obs_len).chain(hidden);
    let weights: f64 = widths.zip(hidden).map(|(&i, &o)| (i as f64 + 1.0) * o as f64).sum();
    let parameters = (signals as f64 + 1.0) * COPIES * weights * 4.0;
    fits("networks.hidden", parameters, format!("{hidden:?}"))?;
    // Observation, action, log-probability (f64); each signal with its value, advantage, target.
    let row = (spec.obs_len + spec.action_len() + 2 + 4 * signals) as f64 * 4.0;
    // Passes over all rows at once keep every layer's outputs and slopes.
    let pass: f64 = hidden.iter().map(|&width| ACTIVATIONS * width as f64 * 4.0).sum();
    let epoch = config.steps_per_epoch as f64 * (row + pass);
    fits("steps_per_epoch", epoch, config.steps_per_epoch.to_string())
}

/// An error for more bytes than this machine has.
fn fits(what: &str, bytes: f64, got: String) -> Result<()> {
    let has = total();
    if bytes <= has {
        return Ok(());
    }
    let wanted = format!("what fits into the {:.0} GiB of this machine", has / GIB);
    let got = format!("{got}, which takes {:.1e} GiB", bytes / GIB);
    Err(Error::invalid(what, wanted, got))
}

const GIB: f64 = (1u64 << 30) as f64;

/// The number of parameters of a critic, the larger network.
fn parameters(config: &Config, spec: &EnvSpec) -> f64 {
    let mut input = (spec.obs_len + spec.action_len()) as f64;
    let mut sum = 0.0;
    for &width in &config.networks.hidden {
        sum += (input + 1.0) * width as f64;
        input = width as f64;
    }
    sum + (input + 1.0) * spec.objectives.len() as f64
}

/// How many numbers one row of a batch takes on its way through a network.
fn widths(config: &Config, spec: &EnvSpec) -> f64 {
    let hidden: f64 = config.networks.hidden.iter().map(|&width| width as f64).sum();
    hidden + (2 * spec.obs_len + spec.action_len() + spec.objectives.len()) as f64
}

/// Bytes of memory, as Linux reports them; on other systems, more than any machine has.
fn total() -> f64 {
    let info = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = info.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse().ok());
    kilobytes.map_or(65_536.0 * GIB, |kilobytes: f64| 1024.0 * kilobytes)
}
