//! One epoch's learning, whatever the method.

use super::clipped::clipped;
use super::natural::natural;
use super::second::second;
use super::{Config, GaussianPolicy, Report, StateValue};
use crate::error::check_len;
use crate::{Error, Result};

/// An epoch's steps, ready for learning. Signals are the reward, then the costs that have critics.
///
/// ```
/// use copq::on_policy::Rows;
///
/// // Two steps, each with one observed number and one action; the only signal is the reward.
/// let rows = Rows {
///     obs: vec![0.1, 0.2],
///     action: vec![0.5, -0.5],
///     log_prob: vec![-1.0, -1.1],
///     advantages: vec![vec![1.0, -1.0]],
///     targets: vec![vec![3.0, 2.0]],
/// };
/// assert_eq!(rows.len(), 2);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Observations as the networks see them, `rows x observation`.
    pub obs: Vec<f32>,
    /// Actions as they were sampled, `rows x action`.
    pub action: Vec<f32>,
    /// log of their density when they were sampled, `rows`.
    pub log_prob: Vec<f64>,
    /// Advantages, `rows` of each signal.
    pub advantages: Vec<Vec<f32>>,
    /// What the critics should have predicted, `rows` of each signal.
    pub targets: Vec<Vec<f32>>,
}

impl Rows {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.log_prob.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.log_prob.is_empty()
    }

    /// The advantage that the policy climbs: the reward's minus the costs' times their multipliers,
    /// divided by 1 + the multipliers' sum, as in OmniSafe's Lagrangian methods.
    pub(super) fn weighed(&self, multipliers: &[f64]) -> Vec<f32> {
        let total = 1.0 + multipliers.iter().sum::<f64>();
        let row = |b: usize| {
            let costs = multipliers.iter().zip(&self.advantages[1..]);
            let cost: f64 = costs.map(|(lambda, cost)| lambda * f64::from(cost[b])).sum();
            ((f64::from(self.advantages[0][b]) - cost) / total) as f32
        };
        (0..self.len()).map(row).collect()
    }

    /// The costs' advantages times their multipliers, summed.
    pub(super) fn cost(&self, multipliers: &[f64]) -> Vec<f32> {
        let row = |b: usize| {
            let costs = multipliers.iter().zip(&self.advantages[1..]);
            costs.map(|(lambda, cost)| lambda * f64::from(cost[b])).sum::<f64>() as f32
        };
        (0..self.len()).map(row).collect()
    }

    fn check(&self, signals: usize, actions: usize) -> Result<()> {
        if self.is_empty() {
            return Err(Error::invalid("rows of an epoch", "at least 1", 0));
        }
        if !self.obs.len().is_multiple_of(self.len()) {
            let wanted = format!("a multiple of the {} rows", self.len());
            return Err(Error::invalid("observations of the rows", wanted, self.obs.len()));
        }
        check_len("actions of the rows", self.action.len(), self.len() * actions)?;
        check_len("signals of the advantages", self.advantages.len(), signals)?;
        check_len("signals of the targets", self.targets.len(), signals)?;
        for values in self.advantages.iter().chain(&self.targets) {
            check_len("rows of a signal", values.len(), self.len())?;
        }
        Ok(())
    }
}

/// Learns from one epoch's rows: the policy by the method's step, each critic from its targets.
/// This is what a [`Learner`](super::Learner) does at the end of an epoch, for callers who gather
/// their own rows ([`GaussianPolicy`] has an example).
///
/// `multipliers` has one number for each critic of a cost; `critics` has the reward's first.
/// `shuffle` puts the row indices into the order of a pass's minibatches.
///
/// Errors: settings that cannot be used, and lengths that do not fit.
///
/// # Panics
///
/// If `shuffle` leaves an index that is not a row's.
pub fn update(
    config: &Config,
    rows: &Rows,
    multipliers: &[f64],
    actor_lr: f64,
    policy: &mut dyn GaussianPolicy,
    critics: &mut [Box<dyn StateValue>],
    shuffle: &mut dyn FnMut(&mut [usize]),
) -> Result<Report> {
    config.check()?;
    let Some(costs) = critics.len().checked_sub(1) else {
        return Err(Error::invalid("critics", "at least the reward's", "none"));
    };
    rows.check(critics.len(), policy.log_std().len())?;
    check_len("multipliers", multipliers.len(), costs)?;
    if config.natural.is_some() {
        return natural(config, rows, multipliers, policy, critics, shuffle);
    }
    // CUP's first step looks at the reward alone.
    let weighed = if config.second.is_some() { &[] } else { multipliers };
    let advantage = rows.weighed(weighed);
    let mut report = clipped(config, rows, &advantage, actor_lr, policy, critics, shuffle)?;
    if let Some(step) = config.second {
        let cost = rows.cost(multipliers);
        report.second_kl = second(config, step, rows, &cost, actor_lr, policy, shuffle)?;
    }
    Ok(report)
}

/// Passes over an epoch's rows in minibatches, each in its own order.
pub(super) struct Passes<'a> {
    rows: &'a Rows,
    batch: usize,
    order: Vec<usize>,
    obs: Vec<f32>,
}

impl<'a> Passes<'a> {
    pub fn new(rows: &'a Rows, batch: usize) -> Self {
        Self { rows, batch, order: (0..rows.len()).collect(), obs: Vec::new() }
    }

    /// One pass: calls `step` with every minibatch's rows and their observations.
    pub fn each(
        &mut self,
        shuffle: &mut dyn FnMut(&mut [usize]),
        mut step: impl FnMut(&[usize], &[f32]) -> Result<()>,
    ) -> Result<()> {
        let Self { rows, batch, order, obs } = self;
        let width = rows.obs.len() / rows.len();
        shuffle(order);
        for picked in order.chunks(*batch) {
            obs.clear();
            for &row in picked {
                obs.extend_from_slice(&rows.obs[row * width..][..width]);
            }
            step(picked, obs)?;
        }
        Ok(())
    }
}
