//! What the critics estimate for one action.

use super::Learner;
use super::update::{Actions, target_actions};
use crate::error::check_len;
use crate::loss::{check_finite, mean_and_std};
use crate::{Net, QView, Result, Rng};

/// What a learner's online critics estimate for one action's discounted return, with one number for
/// each objective.
///
/// ```
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let backend = Still;
/// use copq::{EnvSpec, Learner, Method};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("speed", 1.0);
/// // `copq_candle::Candle::default()` builds networks that learn; these always return the same.
/// let mut learner = Learner::new(Method::cop_td3(), &spec, &backend, 0)?;
/// let estimate = learner.estimate(&[0.1, 0.2], &[0.5])?;
///
/// // Critics that agree leave nothing to be careful about.
/// assert_eq!(estimate.std, [0.0, 0.0]);
/// assert_eq!(estimate.bound, estimate.mean);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct QEstimate {
    /// The critics' mean.
    pub mean: Vec<f64>,
    /// Their standard deviation.
    pub std: Vec<f64>,
    /// Their bound, as in TD targets. Its weighted total is at or below that of the mean. A single
    /// objective's bound may be above its mean, and a cost's is an upper bound.
    pub bound: Vec<f64>,
    /// The weights of that total.
    pub weights: Vec<f64>,
    /// The standard deviation of that total. For separate critics, it is computed as if the errors
    /// of the objectives were independent.
    pub total_std: f64,
}

impl Learner {
    /// What the online critics estimate for an action in [-1, 1]. The bound is that of all critics,
    /// even where a target uses a few drawn critics (REDQ) or only a cost's own critic (CAL).
    pub fn estimate(&mut self, obs: &[f32], action: &[f32]) -> Result<QEstimate> {
        self.online_values(obs, action)?;
        let (critics, n) = (self.critic.critics(), self.objectives.len());
        let values = &self.buffers.q[..critics * n];
        check_finite("Q", values, &self.objectives, self.steps)?;
        let q = QView::new(values, critics, n)?;
        let (mean, std): (Vec<_>, Vec<_>) =
            (0..n).map(|objective| mean_and_std(q, objective)).unzip();
        let weights = self.multiplier.weights();
        let mut bound = vec![0.0; n];
        let query = self.config.lower(q, weights);
        self.projection.project(query, &mut self.buffers.scratch, &mut bound)?;
        let weights: Vec<_> = weights.iter().map(|&w| f64::from(w)).collect();
        let total = |values: &[f32]| -> f32 {
            values.iter().zip(&weights).map(|(&q, w)| f64::from(q) * w).sum::<f64>() as f32
        };
        let total_std = if self.critic.shared() {
            let totals: Vec<_> = values.chunks_exact(n).map(total).collect();
            mean_and_std(QView::new(&totals, critics, 1)?, 0).1
        } else {
            // The pairing of one objective's networks with another's is arbitrary.
            weights
                .iter()
                .zip(&std)
                .map(|(w, std): (&f64, &f64)| (w * std).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let bound = bound.into_iter().map(f64::from).collect();
        Ok(QEstimate { mean, std, bound, weights, total_std })
    }

    /// Writes the online critics' values of an action to the beginning of the buffer `q`.
    pub(super) fn online_values(&mut self, obs: &[f32], action: &[f32]) -> Result<()> {
        check_len("action", action.len(), self.actor.action_len())?;
        self.normalise(obs)?;
        let values = &mut self.buffers.q[..self.critic.critics() * self.objectives.len()];
        self.critic.values(Net::Online, &self.obs, action, values)
    }

    /// Writes an action of the policy that critics learn the values of ([`target_actions`]). For a
    /// stochastic policy, returns its entropy bonus and the objective that it is added to.
    pub(crate) fn target_policy_action(
        &mut self,
        obs: &[f32],
        rng: &mut Rng,
        action: &mut [f32],
    ) -> Result<Option<(usize, f64)>> {
        self.normalise(obs)?;
        let mut log_prob = [0.0];
        let actions = Actions {
            policy_noise: &mut vec![0.0; self.actor.noise_len()],
            log_prob: &mut log_prob,
            noise: &mut vec![0.0; action.len()],
            action,
        };
        target_actions(self.actor.as_mut(), self.config.smoothing, rng, &self.obs, actions)?;
        let bonus = |alpha: f64| -alpha * f64::from(log_prob[0]);
        Ok(self.temperature.as_ref().map(|t| (t.objective(), bonus(t.alpha()))))
    }
}
