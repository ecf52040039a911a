//! Diagonal Gaussians: log-probabilities and divergences, a row at a time, in f64.

use std::f64::consts::TAU;

/// Deviations that many rows share, in the form that densities need.
#[derive(Debug, Default)]
pub(super) struct Deviations {
    /// One over each deviation.
    inverse: Vec<f64>,
    /// The part of a log-probability that depends on neither mean nor action.
    constant: f64,
}

impl Deviations {
    /// The deviations with these logarithms.
    pub fn new(log_std: &[f32]) -> Self {
        let mut new = Self::default();
        new.set(log_std);
        new
    }

    /// Sets the deviations to those with these logarithms.
    pub fn set(&mut self, log_std: &[f32]) {
        self.inverse.clear();
        self.inverse.extend(log_std.iter().map(|&x| libm::exp(-f64::from(x))));
        let total: f64 = log_std.iter().map(|&x| f64::from(x)).sum();
        self.constant = -0.5 * libm::log(TAU) * log_std.len() as f64 - total;
    }

    /// One over each deviation.
    pub fn inverse(&self) -> &[f64] {
        &self.inverse
    }

    /// log of the density of one row's action, summed over the components.
    pub fn log_prob(&self, mean: &[f32], action: &[f32]) -> f64 {
        let squares = self.inverse.iter().zip(mean.iter().zip(action)).map(|(inverse, (m, a))| {
            let z = (f64::from(*a) - f64::from(*m)) * inverse;
            z * z
        });
        self.constant - 0.5 * squares.sum::<f64>()
    }
}

/// KL(p || q), summed over the components.
pub(super) fn kl([p_mean, p_log_std]: [&[f32]; 2], [q_mean, q_log_std]: [&[f32]; 2]) -> f64 {
    let p = p_mean.iter().zip(p_log_std);
    let component = |((p_mean, p_log), (q_mean, q_log)): ((&f32, &f32), (&f32, &f32))| {
        let shift = f64::from(*p_mean) - f64::from(*q_mean);
        let log_ratio = f64::from(*p_log) - f64::from(*q_log);
        let spread = shift * libm::exp(-f64::from(*q_log));
        0.5 * (libm::exp(2.0 * log_ratio) + spread * spread - 1.0) - log_ratio
    };
    p.zip(q_mean.iter().zip(q_log_std)).map(component).sum()
}

/// The mean of KL(p || q) over rows of means; each side has the same deviations for all rows.
pub(super) fn mean_kl([p_mean, p_log_std]: [&[f32]; 2], [q_mean, q_log_std]: [&[f32]; 2]) -> f64 {
    let width = p_log_std.len();
    let rows = p_mean.chunks_exact(width).zip(q_mean.chunks_exact(width));
    let total: f64 = rows.map(|(p, q)| kl([p, p_log_std], [q, q_log_std])).sum();
    total * width as f64 / p_mean.len() as f64
}

/// The entropy, averaged over the components.
pub(super) fn mean_entropy(log_std: &[f32]) -> f64 {
    let mean = log_std.iter().map(|&x| f64::from(x)).sum::<f64>() / log_std.len() as f64;
    0.5 + 0.5 * libm::log(TAU) + mean
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    /// Means of log p(a) and log p(a) - log q(a) over a fine grid of actions.
    #[test]
    fn divergence_and_entropy_are_the_integrals_of_their_definitions() {
        let p: [&[f32]; 2] = [&[0.3], &[-0.2]];
        let q: [&[f32]; 2] = [&[-0.1], &[0.1]];
        let step = 1e-3;
        let [mut mass, mut entropy, mut divergence] = [0.0; 3];
        for i in -12_000..12_000 {
            let action = [(f64::from(i) * step) as f32];
            let log_p = Deviations::new(p[1]).log_prob(p[0], &action);
            let weight = step * libm::exp(log_p);
            mass += weight;
            entropy -= weight * log_p;
            divergence += weight * (log_p - Deviations::new(q[1]).log_prob(q[0], &action));
        }
        assert_abs_diff_eq!(mass, 1.0, epsilon = 1e-5);
        assert_abs_diff_eq!(mean_entropy(p[1]), entropy, epsilon = 1e-5);
        assert_abs_diff_eq!(kl(p, q), divergence, epsilon = 1e-5);
    }
}
