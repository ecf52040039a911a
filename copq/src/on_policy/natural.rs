//! The natural-gradient step (Kakade 2001), as in OmniSafe's RCPO, and the critics' passes after
//! it.

use super::clipped::{Minibatch, Snapshot, fit};
use super::config::NaturalStep;
use super::normal::Deviations;
use super::update::{Passes, Rows};
use super::{Config, GaussianPolicy, Normal, Report, StateValue};
use crate::{Error, Result};

/// Keeps quotients finite, as OmniSafe does.
const EPSILON: f64 = 1e-6;
/// The norm of the residual at which conjugate gradients have converged.
const ARRIVED: f64 = 1e-10;

/// One step of the policy along the natural gradient of the weighted advantage, as far as the
/// target KL allows to second order; then the critics' passes.
pub(super) fn natural(
    config: &Config,
    rows: &Rows,
    multipliers: &[f64],
    policy: &mut dyn GaussianPolicy,
    critics: &mut [Box<dyn StateValue>],
    shuffle: &mut dyn FnMut(&mut [usize]),
) -> Result<Report> {
    let before = Snapshot::new(policy, rows)?;
    let advantage = rows.weighed(multipliers);
    let gradient = ascent(rows, &advantage, policy)?;
    let settings = config.natural.unwrap_or_default();
    let mut fisher = Fisher { rows, damping: settings.damping, policy, product: Vec::new() };
    let direction = conjugate_gradients(settings, &gradient, &mut fisher)?;
    let curvature = dot(&direction, fisher.times(&direction)?);
    if !(curvature >= 0.0 && curvature.is_finite()) {
        let wanted = "a finite number, at least 0 (try more natural.damping, or rewards near 1)";
        return Err(Error::invalid("curvature along the natural gradient", wanted, curvature));
    }
    // KL is half of length^2 x' F x to second order; 1e-8 as in OmniSafe.
    let length = (2.0 * config.target_kl / (curvature + 1e-8)).sqrt();
    let step: Vec<f32> = direction.iter().map(|x| (length * x) as f32).collect();
    policy.shift(&step)?;
    let mut report = Report { kl: vec![before.kl_to(policy, rows)?], ..Report::default() };
    let mut passes = Passes::new(rows, config.batch);
    for _ in 0..config.passes {
        let mut losses = vec![0.0; critics.len()];
        passes.each(shuffle, |picked, obs| fit(config, rows, picked, obs, critics, &mut losses))?;
        report.critic_losses = losses.iter().map(|loss| loss / rows.len() as f64).collect();
    }
    Ok(report)
}

/// The gradient of mean(ratio A) where all ratios are 1.
fn ascent(rows: &Rows, advantage: &[f32], policy: &mut dyn GaussianPolicy) -> Result<Vec<f64>> {
    let mut gradient = vec![0.0; policy.parameters()];
    policy.gradient(
        &rows.obs,
        &mut |Normal { mean, log_std }, grad| {
            let width = log_std.len();
            grad.log_std.fill(0.0);
            let mut all = Minibatch::new(rows);
            all.set(log_std);
            let means = mean.chunks_exact(width).zip(grad.mean.chunks_exact_mut(width));
            for (row, (mean, grad_mean)) in means.enumerate() {
                let scale = f64::from(advantage[row]) / rows.len() as f64;
                all.log_prob_grad(row, scale, mean, grad_mean, grad.log_std);
            }
            Ok(())
        },
        &mut gradient,
    )?;
    Ok(gradient.iter().map(|&x| f64::from(x)).collect())
}

/// The Fisher matrix of a policy on some rows, averaged over rows and action components, with some
/// damping on its diagonal; it is only used in products with vectors.
struct Fisher<'a> {
    rows: &'a Rows,
    damping: f64,
    policy: &'a mut dyn GaussianPolicy,
    product: Vec<f64>,
}

impl Fisher<'_> {
    /// The product with a vector: forward along it, divided by the variances, and back.
    fn times(&mut self, vector: &[f64]) -> Result<&[f64]> {
        let Self { rows, damping, policy, product } = self;
        let width = policy.log_std().len() as f64;
        let direction: Vec<f32> = vector.iter().map(|&x| x as f32).collect();
        let mut moved = vec![0.0; rows.action.len()];
        policy.push_forward(&rows.obs, &direction, &mut moved)?;
        let mut back = vec![0.0; direction.len()];
        policy.gradient(
            &rows.obs,
            &mut |normal, grad| {
                let count = moved.len() as f64;
                let deviations = Deviations::new(normal.log_std);
                let all = grad.mean.iter_mut().zip(&moved).zip(deviations.inverse().iter().cycle());
                for ((grad, &moved), inverse) in all {
                    *grad = (f64::from(moved) * inverse * inverse / count) as f32;
                }
                grad.log_std.fill(0.0);
                Ok(())
            },
            &mut back,
        )?;
        // The deviations' own block is diagonal; they are the last parameters.
        let first_log_std = vector.len() - width as usize;
        product.clear();
        product.extend(vector.iter().zip(&back).enumerate().map(|(i, (x, &back))| {
            let own = if i < first_log_std { f64::from(back) } else { 2.0 / width * x };
            own + *damping * x
        }));
        Ok(product)
    }
}

/// Solves F x = gradient for x, approximately.
fn conjugate_gradients(
    settings: NaturalStep,
    gradient: &[f64],
    fisher: &mut Fisher<'_>,
) -> Result<Vec<f64>> {
    let mut x = vec![0.0; gradient.len()];
    let mut residual = gradient.to_vec();
    let mut direction = residual.clone();
    let mut square = dot(&residual, &residual);
    for _ in 0..settings.iterations {
        let product = fisher.times(&direction)?;
        let length = square / (dot(&direction, product) + EPSILON);
        add(&mut x, length, &direction);
        add(&mut residual, -length, product);
        let next = dot(&residual, &residual);
        if next.sqrt() < ARRIVED {
            break;
        }
        let share = next / (square + EPSILON);
        square = next;
        for (direction, residual) in direction.iter_mut().zip(&residual) {
            *direction = residual + share * *direction;
        }
    }
    Ok(x)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// a <- a + scale b
fn add(a: &mut [f64], scale: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += scale * b);
}
