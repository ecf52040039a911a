//! PPO's passes: ratios that may not move the objective far, and critics beside them.

use super::normal::{log_prob, mean_kl};
use super::update::{Passes, Rows};
use super::{Config, Descent, Normal, NormalGradient, Policy, Report, Value};
use crate::Result;

/// Passes over the rows by policy and critics until the policy has moved far enough.
pub(super) fn clipped(
    config: &Config,
    rows: &Rows,
    advantage: &[f32],
    actor_lr: f64,
    policy: &mut dyn Policy,
    critics: &mut [Box<dyn Value>],
    shuffle: &mut dyn FnMut(&mut [usize]),
) -> Result<Report> {
    let before = Snapshot::new(policy, rows)?;
    let step = Descent { lr: actor_lr, decay: 0.0, max_norm: config.max_norm };
    let mut report = Report::default();
    let mut passes = Passes::new(rows, config.batch);
    for _ in 0..config.passes {
        let mut losses = vec![0.0; critics.len()];
        let mut cut = 0;
        passes.each(shuffle, |picked, obs| {
            fit(config, rows, picked, obs, critics, &mut losses)?;
            policy.descend(obs, step, &mut |normal, mut grad| {
                grad.log_std.fill((-config.entropy / normal.log_std.len() as f64) as f32);
                for (b, &row) in picked.iter().enumerate() {
                    let slope = ratio_slope(config.clip, rows, advantage, row, b, normal);
                    cut += usize::from(slope == 0.0 && advantage[row] != 0.0);
                    add_log_prob_grad(
                        rows,
                        row,
                        b,
                        -slope / picked.len() as f64,
                        normal,
                        &mut grad,
                    );
                }
                Ok(())
            })
        })?;
        report.clip_share = cut as f64 / rows.len() as f64;
        report.critic_losses = losses.iter().map(|loss| loss / rows.len() as f64).collect();
        let kl = before.kl_to(policy, rows)?;
        report.kl.push(kl);
        if kl > config.target_kl {
            break;
        }
    }
    Ok(report)
}

/// d min(ratio A, clamp(ratio) A) / d log pi of a minibatch's `b`-th row.
fn ratio_slope(
    clip: f64,
    rows: &Rows,
    advantage: &[f32],
    row: usize,
    b: usize,
    normal: Normal<'_>,
) -> f64 {
    let advantage = f64::from(advantage[row]);
    let ratio = ratio(rows, row, b, normal);
    let is_cut = if advantage > 0.0 { ratio > 1.0 + clip } else { ratio < 1.0 - clip };
    if is_cut { 0.0 } else { ratio * advantage }
}

/// pi(a) / old pi(a) of a minibatch's `b`-th row.
pub(super) fn ratio(rows: &Rows, row: usize, b: usize, normal: Normal<'_>) -> f64 {
    let width = normal.log_std.len();
    let mean = &normal.mean[b * width..][..width];
    let action = &rows.action[row * width..][..width];
    libm::exp(log_prob(mean, normal.log_std, action) - rows.log_prob[row])
}

/// Adds `scale d log pi(a)` of a minibatch's `b`-th row to the gradient; its means' are written, not
/// added.
pub(super) fn add_log_prob_grad(
    rows: &Rows,
    row: usize,
    b: usize,
    scale: f64,
    normal: Normal<'_>,
    grad: &mut NormalGradient<'_>,
) {
    let width = normal.log_std.len();
    for (j, &log_std) in normal.log_std.iter().enumerate() {
        let at = b * width + j;
        let precision = libm::exp(-2.0 * f64::from(log_std));
        let distance = f64::from(rows.action[row * width + j]) - f64::from(normal.mean[at]);
        grad.mean[at] = (scale * distance * precision) as f32;
        grad.log_std[j] += (scale * (distance * distance * precision - 1.0)) as f32;
    }
}

/// One step of every critic towards the targets of a minibatch's rows; adds up squared errors.
pub(super) fn fit(
    config: &Config,
    rows: &Rows,
    picked: &[usize],
    obs: &[f32],
    critics: &mut [Box<dyn Value>],
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
    pub fn new(policy: &mut dyn Policy, rows: &Rows) -> Result<Self> {
        let log_std = policy.log_std().to_vec();
        let mut mean = vec![0.0; rows.len() * log_std.len()];
        policy.means(&rows.obs, &mut mean)?;
        Ok(Self { mean, log_std })
    }

    /// KL(this || the policy now).
    pub fn kl_to(&self, policy: &mut dyn Policy, rows: &Rows) -> Result<f64> {
        let now = Self::new(policy, rows)?;
        Ok(mean_kl([&self.mean, &self.log_std], [&now.mean, &now.log_std]))
    }
}
