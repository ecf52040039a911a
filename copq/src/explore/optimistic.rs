//! Optimistic exploration: the policy shifted towards the upper bound of the critics, as far as a
//! KL bound allows.

use std::sync::Arc;

use super::{Context, Explore};
use crate::error::check_not_negative;
use crate::projection::{BoundQuery, Directions, Projection, by_name};
use crate::{Net, Optimism, QView, Result};

/// Optimistic Actor Critic (Ciosek et al. 2019) with any projection's upper bound: COP-OAC with
/// [`Cholesky`](crate::projection::Cholesky) (paper eq. 15), Extremum-OAC with
/// [`Extremum`](crate::projection::Extremum).
///
/// The mean of the exploring policy moves by `shift * Sigma_T g / sqrt(g' Sigma_T g)`, where g is
/// the gradient of `u . (mean + beta C R u)` at the policy's mode and Sigma_T is the policy's
/// covariance (paper App. D.1). The KL divergence from the policy is then `shift^2 / 2`, whatever
/// the gradient's size. A zero gradient moves nothing.
///
/// For a deterministic policy, g is the gradient with respect to the action, and Sigma_T is
/// `std^2 I`. For a squashed Gaussian, g is the gradient with respect to the mean before the tanh.
/// Both are the same rule in units of the noise, `noise + shift * h / |h|`, where h is the gradient
/// with respect to the noise.
///
/// ```
/// use copq::projection::Extremum;
/// use copq::{Optimism, Optimistic};
///
/// // Extremum-OAC with the paper's constants, by name or by value; Learner::explore takes either.
/// let by_name = Optimistic::new(Optimism::by("extremum"), 0.1)?;
/// let by_value = Optimistic::default().projection(Extremum);
/// # let _ = (by_name, by_value);
/// assert!(Optimistic::new(Optimism::by("extremun"), 0.1).is_err());
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Optimistic {
    optimism: Optimism,
    /// In units of half the action range.
    std: f32,
    /// The projection whose upper bound is used; `None` for the learner's own.
    projection: Option<Arc<dyn Projection>>,
    buffers: Buffers,
}

/// Buffers for one action, sized at the first.
#[derive(Debug, Default)]
struct Buffers {
    unit: Vec<f64>,
    grad_bound: Vec<f32>,
    grad_action: Vec<f32>,
    noise: Vec<f32>,
    grad_noise: Vec<f32>,
}

impl Default for Optimistic {
    /// The upper bound of the learner's own projection, with the paper's constants (Tables D.2 and
    /// D.3). The noise is 0.1, whatever the method's own noise is.
    fn default() -> Self {
        Self {
            optimism: Optimism::default(),
            std: 0.1,
            projection: None,
            buffers: Buffers::default(),
        }
    }
}

impl Optimistic {
    /// Optimism with these settings; an error if they cannot be used. `std` is the standard
    /// deviation of a deterministic policy's noise, in units of half the action range; other
    /// policies do not use it.
    pub fn new(optimism: Optimism, std: f32) -> Result<Self> {
        check_not_negative("optimistic.std", f64::from(std))?;
        optimism.check()?;
        let projection = optimism.projection.as_deref().map(by_name).transpose()?;
        Ok(Self { optimism, std, projection, ..Self::default() })
    }

    /// Uses the upper bound of a projection different from the learner's, such as one that you
    /// wrote.
    pub fn projection(self, projection: impl Projection + 'static) -> Self {
        Self { projection: Some(Arc::new(projection)), ..self }
    }

    /// Writes the gradient of the scalarised upper bound with respect to the action, at `action`.
    fn action_grad(
        &mut self,
        context: &mut Context<'_>,
        obs: &[f32],
        action: &[f32],
    ) -> Result<()> {
        let Self { optimism, projection, buffers, .. } = self;
        let Context { critic, weights, scratch, .. } = context;
        let projection = projection.as_deref().unwrap_or(context.projection);
        let n = critic.objectives();
        buffers.unit.resize(n, 0.0);
        buffers.grad_bound.resize(n, 0.0);
        buffers.grad_action.resize(action.len(), 0.0);
        Directions::new(weights, 1, n)?.unit(0, &mut buffers.unit);
        buffers.grad_bound.iter_mut().zip(&buffers.unit).for_each(|(grad, &u)| *grad = u as f32);
        let Buffers { grad_bound, grad_action, .. } = buffers;
        let upper = &mut |q: QView<'_>, grad_q: &mut [f32]| {
            projection.vjp(
                BoundQuery { q, weights, step: optimism.beta as f32 },
                scratch,
                grad_bound,
                grad_q,
            )
        };
        critic.action_grad(obs, action, upper, grad_action)
    }
}

impl Explore for Optimistic {
    fn act(&mut self, context: &mut Context<'_>, obs: &[f32], action: &mut [f32]) -> Result<()> {
        context.actor.mode(Net::Online, obs, action)?;
        let shift = self.optimism.shift_at(context.step);
        if shift > 0.0 {
            self.action_grad(context, obs, action)?;
        } else {
            self.buffers.grad_action.clear();
            self.buffers.grad_action.resize(action.len(), 0.0);
        }
        let Self { std, buffers: Buffers { noise, grad_noise, grad_action, .. }, .. } = self;
        let wanted = context.actor.noise_len();
        if wanted == 0 {
            noise.resize(action.len(), 0.0);
            context.rng.fill_normal(noise);
            add_shift(noise, grad_action, shift);
            action
                .iter_mut()
                .zip(noise)
                .for_each(|(a, noise)| *a = (*a + *std * *noise).clamp(-1.0, 1.0));
            return Ok(());
        }
        noise.clear();
        noise.resize(wanted, 0.0);
        grad_noise.resize(wanted, 0.0);
        context.actor.noise_grad(obs, noise, grad_action, grad_noise)?;
        context.rng.fill_normal(noise);
        add_shift(noise, grad_noise, shift);
        context.actor.sample(Net::Online, obs, noise, action, &mut [0.0])
    }
}

/// noise + length * h / |h|; unchanged where h is zero.
fn add_shift(noise: &mut [f32], h: &[f32], length: f64) {
    // Scaled by the largest entry first, so that no square under- or overflows.
    let largest = h.iter().fold(0.0f32, |largest, h| largest.max(h.abs()));
    if largest == 0.0 {
        return;
    }
    let scaled = |h: &f32| f64::from(h / largest);
    let norm = h.iter().map(|h| scaled(h).powi(2)).sum::<f64>().sqrt();
    noise.iter_mut().zip(h).for_each(|(noise, h)| *noise += (length * scaled(h) / norm) as f32);
}

#[cfg(test)]
mod tests {
    use approx::{abs_diff_eq, assert_abs_diff_eq};

    use super::*;

    /// mu = (0.1, 0.2), g = (0.3, -0.4), sigma 0.1: worked out by hand from the method's equations.
    #[test]
    fn fixture() {
        let mut noise = [0.0; 2];
        add_shift(&mut noise, &[0.3, -0.4], 6.86);
        let shifted = [0.1 + 0.1 * noise[0], 0.2 + 0.1 * noise[1]];
        assert_abs_diff_eq!(shifted[..], [0.5116, -0.3488][..], epsilon = 1e-6);
    }

    #[test]
    fn the_shift_has_its_length_whatever_the_gradients_and_none_for_zero() {
        for scale in [1e-30, 1e-3, 1.0, 1e30] {
            let mut noise = [0.0; 3];
            add_shift(&mut noise, &[scale, -2.0 * scale, 3.0 * scale], 6.86);
            let length = noise.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!(abs_diff_eq!(length, 6.86, epsilon = 1e-5), "{scale}: {length}");
        }
        let mut noise = [0.5, 0.25];
        add_shift(&mut noise, &[0.0, -0.0], 6.86);
        assert_eq!(noise, [0.5, 0.25]);
    }
}
