//! CUP's second step: down the costs, close to where the first step led (Yang et al. 2022).

use super::clipped::{Minibatch, Snapshot};
use super::config::SecondStep;
use super::normal::Deviations;
use super::update::{Passes, Rows};
use super::{Config, Descent, GaussianPolicy, Normal};
use crate::Result;

/// Passes that minimise `mean(kappa ratio cost + KL(new || first step's))`; returns the KL the
/// other way round, KL(first step's || new), after each pass. Passes end when that KL is too large.
/// `cost` has the costs' advantages times their multipliers.
pub(super) fn second(
    config: &Config,
    step: SecondStep,
    rows: &Rows,
    cost: &[f32],
    actor_lr: f64,
    policy: &mut dyn GaussianPolicy,
    shuffle: &mut dyn FnMut(&mut [usize]),
) -> Result<Vec<f64>> {
    let kappa = (1.0 - config.discount * config.gae) / (1.0 - config.discount);
    let first = Snapshot::new(policy, rows)?;
    let descent = Descent { lr: actor_lr, decay: 0.0, max_norm: config.max_norm };
    let spread = Deviations::new(&first.log_std);
    let mut minibatch = Minibatch::new(rows);
    let mut divergences = Vec::new();
    let mut passes = Passes::new(rows, config.batch);
    for _ in 0..step.passes {
        passes.each(shuffle, |picked, obs| {
            policy.descend(obs, descent, &mut |Normal { mean, log_std }, grad| {
                let share = 1.0 / picked.len() as f64;
                let width = log_std.len();
                minibatch.set(log_std);
                for ((grad, &now), &then) in
                    grad.log_std.iter_mut().zip(log_std).zip(&first.log_std)
                {
                    let log_ratio = f64::from(now) - f64::from(then);
                    *grad = (libm::exp(2.0 * log_ratio) - 1.0) as f32;
                }
                let means = mean.chunks_exact(width).zip(grad.mean.chunks_exact_mut(width));
                for (&row, (mean, grad_mean)) in picked.iter().zip(means) {
                    let slope = kappa * f64::from(cost[row]) * minibatch.ratio(row, mean);
                    minibatch.log_prob_grad(row, share * slope, mean, grad_mean, grad.log_std);
                    let from = &first.mean[row * width..];
                    for (j, inverse) in spread.inverse().iter().enumerate() {
                        let shift = f64::from(mean[j]) - f64::from(from[j]);
                        grad_mean[j] += (share * shift * inverse * inverse) as f32;
                    }
                }
                Ok(())
            })
        })?;
        let kl = first.kl_to(policy, rows)?;
        divergences.push(kl);
        if kl.is_nan() || kl > config.target_kl {
            break;
        }
    }
    Ok(divergences)
}
