//! The squashed Gaussian of SAC, one action component at a time: a = tanh(mean + std * noise), and
//! its log-probability.

/// Bounds of log std.
pub(crate) const LOG_STD: (f32, f32) = (-20.0, 2.0);

const HALF_LOG_TWO_PI: f64 = 0.918_938_533_204_672_7;

/// What one pair of network outputs and one standard normal give.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Component {
    /// log std as given by the network.
    raw: f32,
    std: f32,
    noise: f32,
    /// The value before the tanh.
    x: f32,
    /// The action.
    pub action: f32,
}

impl Component {
    /// The sample for this mean, log std (not yet clamped) and noise.
    pub fn new(mean: f32, raw: f32, noise: f32) -> Self {
        let std = libm::expf(clamped(raw));
        let x = mean + std * noise;
        Self { raw, std, noise, x, action: libm::tanhf(x) }
    }

    /// log N(x; mean, std) - log(1 - tanh(x)^2), the latter as 2 (log 2 - x - softplus(-2x)), which
    /// does not overflow for any x.
    pub fn log_prob(self) -> f64 {
        let noise = f64::from(self.noise);
        let x = f64::from(self.x);
        let gaussian = -0.5 * noise * noise - f64::from(clamped(self.raw)) - HALF_LOG_TWO_PI;
        gaussian - 2.0 * (std::f64::consts::LN_2 - x - softplus(-2.0 * x))
    }

    /// dL/d(mean, raw log std) from dL/daction and dL/dlog_prob. A log std outside its bounds does
    /// not move.
    pub fn backward(self, grad_action: f32, grad_log_prob: f32) -> (f32, f32) {
        let grad_x = grad_action * self.slope() + 2.0 * grad_log_prob * self.action;
        let inside = (LOG_STD.0..=LOG_STD.1).contains(&self.raw);
        (grad_x, if inside { grad_x * self.std * self.noise - grad_log_prob } else { 0.0 })
    }

    /// daction/dnoise.
    pub fn noise_slope(self) -> f32 {
        self.slope() * self.std
    }

    fn slope(self) -> f32 {
        1.0 - self.action * self.action
    }
}

fn clamped(raw: f32) -> f32 {
    raw.clamp(LOG_STD.0, LOG_STD.1)
}

fn softplus(y: f64) -> f64 {
    y.max(0.0) + libm::log1p(libm::exp(-y.abs()))
}

#[cfg(test)]
mod tests {
    use approx::{abs_diff_eq, assert_abs_diff_eq};

    use super::*;

    /// The density integrates to one over the actions: the log-probability is that of the squashed
    /// value.
    #[test]
    fn probabilities_sum_to_one() {
        for (mean, log_std) in [(0.0, -1.0), (0.7, -0.5), (-1.5, 0.2)] {
            let steps = 400_000;
            // The midpoint rule over the noise: p(a) da = p(a) (da/dnoise) dnoise.
            let sum: f64 = (0..steps)
                .map(|i| {
                    let noise = (-8.0 + 16.0 * (f64::from(i) + 0.5) / f64::from(steps)) as f32;
                    let sample = Component::new(mean, log_std, noise);
                    let slope = 1.0 / f64::from(sample.x).cosh().powi(2) * f64::from(sample.std);
                    sample.log_prob().exp() * slope * 16.0 / f64::from(steps)
                })
                .sum();
            assert!(abs_diff_eq!(sum, 1.0, epsilon = 1e-5), "{mean}, {log_std}: {sum}");
        }
    }

    #[test]
    fn it_stays_finite_where_the_tanh_is_flat() {
        for (mean, raw, noise) in [(50.0, 0.0, 1.0), (-300.0, 5.0, -3.0), (0.0, -40.0, 0.5)] {
            let sample = Component::new(mean, raw, noise);
            let (grad_mean, grad_raw) = sample.backward(1.0, 1.0);
            assert!(sample.log_prob().is_finite() && grad_mean.is_finite() && grad_raw.is_finite());
        }
        // Saturated at 50: log(1 - tanh^2) is 2 log 2 - 2x to the last digit.
        let wanted = -0.5 - HALF_LOG_TWO_PI - 2.0 * std::f64::consts::LN_2 + 2.0 * 51.0;
        assert_abs_diff_eq!(Component::new(50.0, 0.0, 1.0).log_prob(), wanted, epsilon = 1e-9);
    }

    #[test]
    fn log_std_is_clamped_and_then_does_not_move() {
        assert_eq!(Component::new(0.0, -50.0, 1.0).std, libm::expf(-20.0));
        assert_eq!(Component::new(0.0, 9.0, 1.0).std, libm::expf(2.0));
        assert_eq!(Component::new(0.0, 9.0, 1.0).backward(1.0, 1.0).1, 0.0);
        assert_ne!(Component::new(0.0, 1.9, 1.0).backward(1.0, 1.0).1, 0.0);
    }
}
