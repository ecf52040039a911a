//! Checks of the public methods' arguments. Each error names the slice, what was wanted and what
//! was given.

use copq::error::check_len;
use copq::{EnvSpec, Error, Networks, Result};

/// An error unless networks can be built from these settings.
pub(crate) fn settings(spec: &EnvSpec, networks: &Networks) -> Result<()> {
    spec.check()?;
    networks.check()
}

/// The same for networks that support only f32.
pub(crate) fn plain_settings(spec: &EnvSpec, networks: &Networks) -> Result<()> {
    spec.check()?;
    networks.check_f32("networks by autograd")
}

/// The number of rows in a batch of observations.
pub(crate) fn rows(obs: &[f32], observation: usize) -> Result<usize> {
    if obs.is_empty() || !obs.len().is_multiple_of(observation) {
        return Err(Error::invalid(
            "observations",
            format!("a positive multiple of {observation} values"),
            obs.len(),
        ));
    }
    finite("observations", obs, observation)?;
    Ok(obs.len() / observation)
}

/// An error that names the first row of an input with a NaN or an infinity in it.
pub(crate) fn finite(what: &str, values: &[f32], width: usize) -> Result<()> {
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => {
            let got = format!("{} in row {}", values[i], i / width);
            Err(Error::invalid(what, "finite numbers", got))
        }
    }
}

/// An error unless `values` is `rows x width`.
pub(crate) fn batch(what: &str, values: &[f32], rows: usize, width: usize) -> Result<()> {
    check_len(what, values.len(), rows * width)
}

/// An error if a deterministic policy was given noise.
pub(crate) fn deterministic(noise: &[f32]) -> Result<()> {
    if noise.is_empty() {
        return Ok(());
    }
    Err(Error::invalid("noise", "no values: the policy is deterministic", noise.len()))
}

/// An error unless a sample of a stochastic policy has room for every row.
pub(crate) fn sample(
    noise: &[f32],
    action: &[f32],
    log_prob: &[f32],
    rows: usize,
    width: usize,
) -> Result<()> {
    batch("actions", action, rows, width)?;
    batch("noise", noise, rows, width)?;
    finite("noise", noise, width)?;
    batch("log-probabilities", log_prob, rows, 1)
}

/// An error unless the averaging rate is in [0, 1].
pub(crate) fn tau(tau: f32) -> Result<()> {
    if (0.0..=1.0).contains(&tau) {
        Ok(())
    } else {
        Err(Error::invalid("tau", "a number in [0, 1]", tau))
    }
}
