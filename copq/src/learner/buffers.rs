//! Buffers and metric names of an update, made once so that a warm update allocates nothing.

use crate::loss::{correlation, mean_and_std};
use crate::{Actor, Config, Critic, Observer, QView, Scratch};

/// Buffers of an update, sized once.
#[derive(Debug)]
pub(super) struct Buffers {
    pub(super) scratch: Scratch,
    /// Smoothing noise and next actions, `rows x action`.
    pub(super) noise: Vec<f32>,
    pub(super) next_action: Vec<f32>,
    /// A stochastic policy's noise, `rows x noise`, and log-probabilities, `rows`; empty for a
    /// deterministic one.
    pub(super) policy_noise: Vec<f32>,
    pub(super) log_prob: Vec<f32>,
    /// The critics' values at the replayed actions after their step, `critics x rows x objectives`,
    /// and the target critics' values at the next actions.
    pub(super) q: Vec<f32>,
    pub(super) next_q: Vec<f32>,
    /// The positions of all critics; the first few are those drawn for a target.
    pub(super) positions: Vec<usize>,
    /// TD targets, `rows x objectives`, or `critics x rows x objectives` if each critic has its own
    /// targets.
    pub(super) target: Vec<f32>,
    /// The bounds at the replayed actions, the bounds at the policy's own actions, and the gradient
    /// of the actor's loss with respect to the latter, `rows x objectives`.
    pub(super) bound: Vec<f32>,
    pub(super) actor_bound: Vec<f32>,
    pub(super) grad_bound: Vec<f32>,
    /// One number per objective.
    pub(super) losses: Vec<f64>,
    pub(super) losses_after: Vec<f64>,
    pub(super) loss_weights: Vec<f64>,
    pub(super) mean: Vec<f32>,
}

/// Names of logged scalars, made once so that logging allocates nothing.
#[derive(Debug)]
pub(super) struct Names {
    pub(super) loss: Vec<String>,
    pub(super) q: Vec<String>,
    pub(super) std: Vec<String>,
    /// One for each pair of objectives, if joint critics estimate them.
    pub(super) correlation: Vec<(String, [usize; 2])>,
    pub(super) target: Vec<String>,
    pub(super) famo: Vec<String>,
    pub(super) bound: Vec<String>,
}

impl Buffers {
    pub(super) fn new(config: &Config, actor: &dyn Actor, critic: &dyn Critic) -> Self {
        let rows = config.batch;
        let action = actor.action_len();
        let stochastic = usize::from(actor.noise_len() > 0);
        let critics = critic.critics();
        let n = critic.objectives();
        let targets = if config.own_cost_targets { critics } else { 1 };
        let row_values = || vec![0.0; rows * n];
        Self {
            scratch: Scratch::default(),
            noise: vec![0.0; rows * action],
            next_action: vec![0.0; rows * action],
            policy_noise: vec![0.0; rows * actor.noise_len()],
            log_prob: vec![0.0; rows * stochastic],
            q: vec![0.0; critics * rows * n],
            next_q: vec![0.0; critics * rows * n],
            positions: (0..critics).collect(),
            target: vec![0.0; targets * rows * n],
            bound: row_values(),
            actor_bound: row_values(),
            grad_bound: row_values(),
            losses: vec![0.0; n],
            losses_after: vec![0.0; n],
            loss_weights: vec![1.0; n],
            mean: vec![0.0; n],
        }
    }
}

impl Names {
    pub(super) fn new(objectives: &[&str], are_joint: bool) -> Self {
        let named =
            |kind: &str| objectives.iter().map(|objective| format!("{kind}/{objective}")).collect();
        let pair = |i: usize, j: usize| {
            (format!("correlation/{}/{}", objectives[i], objectives[j]), [i, j])
        };
        let n = if are_joint { objectives.len() } else { 0 };
        Self {
            correlation: (0..n).flat_map(|i| (i + 1..n).map(move |j| pair(i, j))).collect(),
            loss: named("critic_loss"),
            q: named("q"),
            std: named("q_std"),
            target: named("target"),
            famo: named("famo"),
            bound: named("bound"),
        }
    }

    /// Reports the critics' mean values, their spread, and its correlation between objectives.
    pub(super) fn log_values(&self, log: &mut dyn Observer, step: u64, q: QView<'_>) {
        for (i, (mean_name, std_name)) in self.q.iter().zip(&self.std).enumerate() {
            let (mean, std) = mean_and_std(q, i);
            log.scalar(step, mean_name, mean);
            log.scalar(step, std_name, std);
        }
        for (name, pair) in &self.correlation {
            log.scalar(step, name, correlation(q, *pair));
        }
    }
}

/// The mean of each column of a `rows x objectives` array.
pub(super) fn column_means(values: &[f32], means: &mut [f32]) {
    let n = means.len();
    let rows = (values.len() / n) as f64;
    for (i, mean) in means.iter_mut().enumerate() {
        *mean =
            (values.iter().skip(i).step_by(n).map(|&x| f64::from(x)).sum::<f64>() / rows) as f32;
    }
}

/// Reports one number per objective.
pub(super) fn log_each<T: Copy + Into<f64>>(
    log: &mut dyn Observer,
    step: u64,
    names: &[String],
    values: &[T],
) {
    for (name, &value) in names.iter().zip(values) {
        log.scalar(step, name, value.into());
    }
}
