//! The arithmetic of TD targets, and the choice of the critics that make one.

use crate::{Batch, Rng};

/// y = r + gamma (1 - d) y for one critic's targets, or those that all critics share.
pub(super) fn discount(target: &mut [f32], batch: &Batch, gamma: f32) {
    let n = target.len() / batch.alive.len();
    let rows = target.chunks_exact_mut(n).zip(batch.reward.chunks_exact(n)).zip(&batch.alive);
    for ((target, reward), alive) in rows {
        let discount = gamma * alive;
        for (y, r) in target.iter_mut().zip(reward) {
            *y = r + discount * *y;
        }
    }
}

/// Draws `count` of the positions without replacement, and puts them first.
pub(super) fn draw(rng: &mut Rng, count: usize, positions: &mut [usize]) {
    // From the same order every time, so that the stream alone decides.
    positions.iter_mut().enumerate().for_each(|(i, position)| *position = i);
    for i in 0..count {
        let j = i + rng.below(positions.len() - i);
        positions.swap(i, j);
    }
}

/// Gives every critic the first `shared` targets, except for costs, which keep its own values.
pub(super) fn bootstrap_own_costs(target: &mut [f32], shared: usize, q: &[f32], is_cost: &[bool]) {
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
