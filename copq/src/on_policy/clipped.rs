//! PPO's passes (Schulman et al. 2017, eq. 7): clipped ratios for the policy, and fits of the
//! critics.

use super::normal::{Deviations, mean_kl};
use super::update::{Passes, Rows};
use super::{Config, Descent, GaussianPolicy, Normal, Report, StateValue};
use crate::Result;

/// Passes of policy and critics over the rows, until the policy has moved far enough.
pub(super) fn clipped(
    config: &Config,
    rows: &Rows,
    advantage: &[f32],
    actor_lr: f64,
    policy: &mut dyn GaussianPolicy,
    critics: &mut [Box<dyn StateValue>],
    shuffle: &mut dyn FnMut(&mut [usize]),
) -> Result<Report> {
    let before = Snapshot::new(policy, rows)?;
    let step = Descent { lr: actor_lr, decay: 0.0, max_norm: config.max_norm };
    let mut report = Report::default();
    let mut minibatch = Minibatch::new(rows);
    let mut passes = Passes::new(rows, config.batch);
    for _ in 0..config.passes {
        let mut losses = vec![0.0; critics.len()];
        let mut cut = 0;
        passes.each(shuffle, |picked, obs| {
            fit(config, rows, picked, obs, critics, &mut losses)?;
            policy.descend(obs, step, &mut |Normal { mean, log_std }, grad| {
                let width = log_std.len();
                grad.log_std.fill((-config.entropy / width as f64) as f32);
                minibatch.set(log_std);
                let means = mean.chunks_exact(width).zip(grad.mean.chunks_exact_mut(width));
                for (&row, (mean, grad_mean)) in picked.iter().zip(means) {
                    let gain = f64::from(advantage[row]);
                    let slope = slope(config.clip, minibatch.ratio(row, mean), gain);
                    cut += usize::from(slope == 0.0 && gain != 0.0);
                    let scale = -slope / picked.len() as f64;
                    minibatch.log_prob_grad(row, scale, mean, grad_mean, grad.log_std);
                }
                Ok(())
            })
        })?;
        report.clip_share = cut as f64 / rows.len() as f64;
        report.critic_losses = losses.iter().map(|loss| loss / rows.len() as f64).collect();
        let kl = before.kl_to(policy, rows)?;
        report.kl.push(kl);
        if kl.is_nan() || kl > config.target_kl {
            break;
        }
    }
    Ok(report)
}

/// A minibatch under a policy's Gaussians: ratios of its rows' probabilities, and their gradients.
pub(super) struct Minibatch<'a> {
    rows: &'a Rows,
    deviations: Deviations,
}

impl<'a> Minibatch<'a> {
    pub fn new(rows: &'a Rows) -> Self {
        Self { rows, deviations: Deviations::default() }
    }

    /// Sets the deviations for the rows that follow.
    pub fn set(&mut self, log_std: &[f32]) {
        self.deviations.set(log_std);
    }

    /// pi(a) / old pi(a) of a row, given its mean.
    pub fn ratio(&self, row: usize, mean: &[f32]) -> f64 {
        let action = &self.rows.action[row * mean.len()..][..mean.len()];
        libm::exp(self.deviations.log_prob(mean, action) - self.rows.log_prob[row])
    }

    /// Writes `scale d log pi(a) / d mean` of a row, and adds the gradient in the deviations'
    /// logarithms.
    pub fn log_prob_grad(
        &self,
        row: usize,
        scale: f64,
        mean: &[f32],
        grad_mean: &mut [f32],
        grad_log_std: &mut [f32],
    ) {
        let action = &self.rows.action[row * mean.len()..];
        for (j, &inverse) in self.deviations.inverse().iter().enumerate() {
            let z = (f64::from(action[j]) - f64::from(mean[j])) * inverse;
            grad_mean[j] = (scale * z * inverse) as f32;
            grad_log_std[j] += (scale * (z * z - 1.0)) as f32;
        }
    }
}

/// d min(ratio A, clamp(ratio) A) / d log pi.
fn slope(clip: f64, ratio: f64, advantage: f64) -> f64 {
    let is_cut = if advantage > 0.0 { ratio > 1.0 + clip } else { ratio < 1.0 - clip };
    if is_cut { 0.0 } else { ratio * advantage }
}

/// One step of every critic towards the targets of a minibatch's rows; adds up squared errors.
pub(super) fn fit(
    config: &Config,
    rows: &Rows,
    picked: &[usize],
    obs: &[f32],
    critics: &mut [Box<dyn StateValue>],
    losses: &mut [f64],
) -> Result<()> {
    let step = Descent {
        lr: config.networks.critic_lr,
        decay: config.critic_decay,
        max_norm: config.max_norm,
    };
    for ((critic, targets), loss) in critics.iter_mut().zip(&rows.targets).zip(losses) {
        critic.descend(obs, step, &mut |value, grad| {
            for ((grad, value), &row) in grad.iter_mut().zip(value).zip(picked) {
                let error = value - targets[row];
                *loss += f64::from(error * error);
                *grad = 2.0 * error / picked.len() as f32;
            }
            Ok(())
        })?;
    }
    Ok(())
}

/// A policy's Gaussians on all rows, to be compared with later ones.
pub(super) struct Snapshot {
    pub mean: Vec<f32>,
    pub log_std: Vec<f32>,
}

impl Snapshot {
    pub fn new(policy: &mut dyn GaussianPolicy, rows: &Rows) -> Result<Self> {
        let log_std = policy.log_std().to_vec();
        let mut mean = vec![0.0; rows.len() * log_std.len()];
        policy.means(&rows.obs, &mut mean)?;
        Ok(Self { mean, log_std })
    }

    /// KL(this || the policy now).
    pub fn kl_to(&self, policy: &mut dyn GaussianPolicy, rows: &Rows) -> Result<f64> {
        let now = Self::new(policy, rows)?;
        Ok(mean_kl([&self.mean, &self.log_std], [&now.mean, &now.log_std]))
    }
}
