//! Adam in one pass over the flat buffers.

use pulp::Arch;

use crate::adam::{BETA1, BETA2, EPSILON, Step};
use crate::learned::Learned;

/// One step of the online parameters against `grad`.
pub(super) fn step(learned: &mut Learned, grad: &[f32], lr: f64) {
    learned.steps += 1;
    let Step { rate, root } = Step::new(lr, learned.steps);
    let (rate, scale) = (rate as f32, (1.0 / root) as f32);
    let (decay1, decay2, epsilon) = (BETA1 as f32, BETA2 as f32, EPSILON as f32);
    let (fresh1, fresh2) = ((1.0 - BETA1) as f32, (1.0 - BETA2) as f32);
    let moments = learned.m.iter_mut().zip(&mut learned.v);
    let all = learned.online.iter_mut().zip(moments).zip(grad);
    Arch::new().dispatch(|| {
        for ((x, (m, v)), g) in all {
            *m = decay1 * *m + fresh1 * g;
            *v = decay2 * *v + fresh2 * (g * g);
            *x -= rate * *m / (v.sqrt() * scale + epsilon);
        }
    });
}
