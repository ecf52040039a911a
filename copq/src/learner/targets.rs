//! TD targets: what the target critics expect of the next state, discounted, plus the reward.

use super::Learner;
use super::buffers::{Buffers, column_means, log_each};
use crate::loss::{check_finite, margin};
use crate::{Batch, BoundQuery, Config, Net, Observer, QView, Result, Rng};

impl Config {
    /// The critics' bound as far on the cautious side as in TD targets.
    pub(super) fn lower<'a>(&self, q: QView<'a>, weights: &'a [f32]) -> BoundQuery<'a> {
        BoundQuery { q, weights, step: -self.pessimism as f32 }
    }
}

impl Learner {
    /// y = r + gamma (1 - d) (lower bound of the target critics at s', a'), less alpha log
    /// pi(a'|s') on the objective that the entropy bonus belongs to: paper eq. 13, with the
    /// terminal mask.
    pub(super) fn targets(&mut self, log: &mut dyn Observer) -> Result<()> {
        let critics = self.target_values()?;
        let n = self.objectives.len();
        let shared = self.batch.reward.len();
        let Buffers { next_q, target, log_prob, scratch, mean, .. } = &mut self.buffers;
        let chosen = QView::new(&next_q[..critics * shared], critics, n)?;
        let lower = self.config.lower(chosen, self.multiplier.weights());
        self.projection.project(lower, scratch, &mut target[..shared])?;
        let pessimism = margin(chosen, &target[..shared], self.multiplier.actor_weights());
        log.scalar(self.steps, "pessimism/target", pessimism);
        if let Some(temperature) = &self.temperature {
            let alpha = temperature.alpha() as f32;
            let e = temperature.objective();
            for (row, log_prob) in target[..shared].chunks_exact_mut(n).zip(log_prob) {
                row[e] -= alpha * *log_prob;
            }
        }
        if self.config.own_cost_targets {
            bootstrap_own_costs(target, shared, next_q, &self.is_cost);
        }
        for target in target.chunks_exact_mut(shared) {
            discount(target, &self.batch, self.config.discount as f32);
            check_finite("TD target", target, &self.objectives, self.steps)?;
        }
        log.scalar(self.steps, "clip_rate", scratch.clip_rate());
        column_means(target, mean);
        log_each(log, self.steps, &self.names.target, mean);
        Ok(())
    }

    /// The values at s', a' of the target critics that count: all, or a few drawn for this update
    /// (REDQ). They come first in `next_q`; returns how many critics they are of.
    fn target_values(&mut self) -> Result<usize> {
        let Buffers { next_q, positions, next_action, .. } = &mut self.buffers;
        let next_obs = &self.batch.next_obs;
        let Some(subset) = self.config.subset else {
            self.critic.values(Net::Target, next_obs, next_action, next_q)?;
            return Ok(self.critic.critics());
        };
        draw(&mut self.streams.subset, subset, positions);
        let next_q = &mut next_q[..subset * self.batch.reward.len()];
        self.critic.values_of(Net::Target, &positions[..subset], next_obs, next_action, next_q)?;
        Ok(subset)
    }
}

/// y = r + gamma (1 - d) y for one critic's targets, or those that all critics share.
fn discount(target: &mut [f32], batch: &Batch, gamma: f32) {
    let n = target.len() / batch.alive.len();
    let rows = target.chunks_exact_mut(n).zip(batch.reward.chunks_exact(n)).zip(&batch.alive);
    for ((target, reward), alive) in rows {
        let discount = gamma * alive;
        for (y, r) in target.iter_mut().zip(reward) {
            *y = r + discount * *y;
        }
    }
}

/// Draws `count` of the positions without replacement; they come first.
fn draw(rng: &mut Rng, count: usize, positions: &mut [usize]) {
    // From the same order every time, so that the stream alone decides.
    positions.iter_mut().enumerate().for_each(|(i, position)| *position = i);
    for i in 0..count {
        let j = i + rng.below(positions.len() - i);
        positions.swap(i, j);
    }
}

/// Gives every critic the targets that come first, `shared` of them, but for costs its own value.
fn bootstrap_own_costs(target: &mut [f32], shared: usize, q: &[f32], is_cost: &[bool]) {
    let (first, others) = target.split_at_mut(shared);
    for (own, q) in others.chunks_exact_mut(shared).zip(q.chunks_exact(shared).skip(1)) {
        own.copy_from_slice(first);
        keep_costs(own, q, is_cost);
    }
    keep_costs(first, q, is_cost);
}

fn keep_costs(target: &mut [f32], q: &[f32], is_cost: &[bool]) {
    for (target, q) in target.chunks_exact_mut(is_cost.len()).zip(q.chunks_exact(is_cost.len())) {
        for i in (0..is_cost.len()).filter(|&i| is_cost[i]) {
            target[i] = q[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stream;

    #[test]
    fn every_pair_of_critics_is_drawn_equally_often() {
        let mut rng = Rng::new(1, Stream::Subset);
        let mut counts = [[0; 10]; 10];
        let mut positions = [0; 10];
        for _ in 0..90_000 {
            draw(&mut rng, 2, &mut positions);
            counts[positions[0]][positions[1]] += 1;
        }
        for (i, row) in counts.iter().enumerate() {
            assert!(row.iter().enumerate().all(|(j, &n)| if i == j {
                n == 0
            } else {
                (850..1150).contains(&n)
            }));
        }
    }

    #[test]
    fn costs_keep_their_own_critic() {
        // Two critics, one row, cost and reward.
        let mut target = [0.0, 7.0, 0.0, 0.0];
        bootstrap_own_costs(&mut target, 2, &[1.0, 2.0, 3.0, 4.0], &[true, false]);
        assert_eq!(target, [1.0, 7.0, 3.0, 7.0]);
    }
}
