//! Several rows at once are the same rows one after the other, bit for bit, whatever becomes of
//! their neighbours.

use copq::projection::{Bound, Cholesky, Deviations, Ellipsoid, Projection, QView, Scratch, Work};
use proptest::prelude::*;

/// Cholesky as a method from outside the crate would be called: one row at a time.
#[derive(Debug)]
struct OneByOne;

impl Ellipsoid for OneByOne {
    fn name(&self) -> &'static str {
        "one-by-one"
    }

    fn offset(&self, x: &Deviations<'_>, u: &[f64], work: &mut Work, out: &mut [f64]) {
        Cholesky.offset(x, u, work, out);
    }

    fn offset_vjp(
        &self,
        x: &Deviations<'_>,
        u: &[f64],
        work: &mut Work,
        grad: &[f64],
        grad_x: &mut [f64],
    ) {
        Cholesky.offset_vjp(x, u, work, grad, grad_x);
    }
}

/// The bits of bounds, gradients and clip rate.
fn bits(method: &dyn Projection, bound: Bound<'_>, grad: &[f32]) -> (Vec<u32>, Vec<u32>, f64) {
    let mut scratch = Scratch::default();
    let mut out = grad.to_vec();
    let mut grad_q = bound.q.values().to_vec();
    method.project(bound, &mut scratch, &mut out).unwrap();
    let clip_rate = scratch.clip_rate();
    method.vjp(bound, &mut scratch, grad, &mut grad_q).unwrap();
    let bits = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect();
    (bits(out), bits(grad_q), clip_rate)
}

/// Makes every kind of degenerate row of a generic one: agreement, a certain first objective,
/// collinear ones, small ones.
fn degrade(q: &mut [f32], (critics, rows, objectives): (usize, usize, usize), kinds: &[u8]) {
    for k in 0..critics {
        for row in 0..rows {
            let start = (k * rows + row) * objectives;
            let (before, values) = q.split_at_mut(start);
            let values = &mut values[..objectives];
            match kinds[row] {
                0 if k > 0 => values.copy_from_slice(&before[row * objectives..][..objectives]),
                1 => values[0] = 5.0,
                2 => (1..objectives).for_each(|i| values[i] = -3.0 * values[0]),
                3 => values.iter_mut().for_each(|q| *q *= 1e-12),
                4 => values.iter_mut().for_each(|q| *q = q.round()),
                _ => {}
            }
        }
    }
}

/// More rows than two blocks with a rest, so that there are blocks, a rest, and batches that are
/// only a rest.
const MOST: usize = 21;

proptest! {
    #[test]
    fn blocks_are_their_rows(
        (critics, rows, objectives) in (1..7_usize, 1..=MOST, 1..6_usize),
        q in prop::collection::vec(-9.0..9.0_f32, 6 * MOST * 5),
        kinds in prop::collection::vec(0..9_u8, MOST),
        weights in prop::collection::vec(prop_oneof![-1.0..-0.01_f32, 0.01..1.0_f32], MOST * 5),
        grad in prop::collection::vec(prop_oneof![Just(-0.0_f32), -2.0..2.0_f32], MOST * 5),
        shared in any::<bool>(),
        step in -2.0..2.0_f32,
    ) {
        let mut q = q[..critics * rows * objectives].to_vec();
        degrade(&mut q, (critics, rows, objectives), &kinds);
        let weights = &weights[..if shared { objectives } else { rows * objectives }];
        let bound = Bound { q: QView::new(&q, critics, objectives).unwrap(), weights, step };
        let grad = &grad[..rows * objectives];
        prop_assert_eq!(bits(&Cholesky, bound, grad), bits(&OneByOne, bound, grad));
    }
}
