//! CUP's second step: down the costs, not far from where the first step led (Yang et al. 2022).

use super::clipped::{Snapshot, add_log_prob_grad, ratio};
use super::config::SecondStep;
use super::update::{Passes, Rows};
use super::{Config, Descent, Policy};
use crate::Result;

/// Passes that minimise `mean(kappa ratio cost + KL(new || first step's))`; returns KL(first step's
/// || new) after each, the other way round, by which they end. `cost` has the costs' advantages by
/// their multipliers.
pub(super) fn second(
    config: &Config,
    step: SecondStep,
    rows: &Rows,
    cost: &[f32],
    actor_lr: f64,
    policy: &mut dyn Policy,
    shuffle: &mut dyn FnMut(&mut [usize]),
) -> Result<Vec<f64>> {
    let kappa = (1.0 - config.discount * config.gae) / (1.0 - config.discount);
    let first = Snapshot::new(policy, rows)?;
    let descent = Descent { lr: actor_lr, decay: 0.0, max_norm: config.max_norm };
    let mut divergences = Vec::new();
    let mut passes = Passes::new(rows, config.batch);
    for _ in 0..step.passes {
        passes.each(shuffle, |picked, obs| {
            policy.descend(obs, descent, &mut |normal, mut grad| {
                let share = 1.0 / picked.len() as f64;
                grad.log_std.fill(0.0);
                for (b, &row) in picked.iter().enumerate() {
                    let slope = kappa * f64::from(cost[row]) * ratio(rows, row, b, normal);
                    add_log_prob_grad(rows, row, b, share * slope, normal, &mut grad);
                    let width = normal.log_std.len();
                    for j in 0..width {
                        let precision = libm::exp(-2.0 * f64::from(first.log_std[j]));
                        let mean = f64::from(normal.mean[b * width + j]);
                        let shift = mean - f64::from(first.mean[row * width + j]);
                        grad.mean[b * width + j] += (share * shift * precision) as f32;
                    }
                }
                for (grad, (now, then)) in
                    grad.log_std.iter_mut().zip(normal.log_std.iter().zip(&first.log_std))
                {
                    let log_ratio = f64::from(*now) - f64::from(*then);
                    *grad += (libm::exp(2.0 * log_ratio) - 1.0) as f32;
                }
                Ok(())
            })
        })?;
        let kl = first.kl_to(policy, rows)?;
        divergences.push(kl);
        if kl > config.target_kl {
            break;
        }
    }
    Ok(divergences)
}
