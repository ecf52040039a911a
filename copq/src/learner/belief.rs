//! What the critics believe of one action.

use super::Learner;
use crate::error::check_len;
use crate::loss::mean_and_std;
use crate::method::Smoothing;
use crate::{BoundQuery, Net, QView, Result};

/// What a learner's critics believe of one action's discounted returns, a number for each objective.
///
/// ```
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # use still::Still;
/// # let backend = Still;
/// use copq::{Belief, EnvSpec, Learner, Method};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("speed", 1.0);
/// // `copq_candle::Candle::default()` builds networks that learn; these say the same of everything.
/// let mut learner = Learner::new(Method::cop_td3(), &spec, &backend, 0)?;
/// let mut belief = Belief::default();
/// learner.belief(&[0.1, 0.2], &[0.5], &mut belief)?;
///
/// // Critics that agree leave nothing to be careful about.
/// assert_eq!(belief.std, [0.0, 0.0]);
/// assert_eq!(belief.bound, belief.mean);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Belief {
    /// The critics' mean.
    pub mean: Vec<f32>,
    /// Their standard deviation.
    pub std: Vec<f32>,
    /// Their bound on the careful side, as far from the mean as in TD targets.
    pub bound: Vec<f32>,
}

impl Learner {
    /// Writes what the online critics believe of an action in [-1, 1]; where targets draw a few
    /// critics (REDQ), the bound here is of all.
    pub fn belief(&mut self, obs: &[f32], action: &[f32], belief: &mut Belief) -> Result<()> {
        check_len("action", action.len(), self.actor.action_len())?;
        self.take_in(obs)?;
        let (critics, n) = (self.critic.critics(), self.objectives.len());
        let values = &mut self.buffers.q[..critics * n];
        self.critic.values(Net::Online, &self.obs, action, values)?;
        let q = QView::new(values, critics, n)?;
        let of_all: Vec<_> = (0..n).map(|objective| mean_and_std(q, objective)).collect();
        belief.mean = of_all.iter().map(|&(mean, _)| mean as f32).collect();
        belief.std = of_all.iter().map(|&(_, std)| std as f32).collect();
        belief.bound.resize(n, 0.0);
        let step = -self.config.pessimism as f32;
        let bound = BoundQuery { q, weights: self.multiplier.weights(), step };
        self.projection.project(bound, &mut self.buffers.scratch, &mut belief.bound)
    }

    /// The noise of its target actions, if they have some.
    pub(crate) fn smoothing(&self) -> Option<Smoothing> {
        self.config.smoothing
    }
}
