//! Adam and Polyak averaging in one pass over parameters.

use std::ops::Range;

use bytemuck::{cast_slice, cast_slice_mut};
use pulp::Arch;

use super::panels::PanelRow;
use crate::adam::{BETA1, BETA2, EPSILON, Step};
use crate::learned::Learned;

/// The present step of some online parameters, those of `lines`, against `grad`; then their targets
/// go `tau` of the way to them.
pub(super) fn step(
    learned: &mut Learned<PanelRow>,
    lines: Range<usize>,
    grad: &[PanelRow],
    lr: f64,
    tau: f32,
) {
    let Step { rate, root } = Step::new(lr, learned.steps);
    let rate = rate as f32;
    let scale = (1.0 / root) as f32;
    let decay1 = BETA1 as f32;
    let decay2 = BETA2 as f32;
    let epsilon = EPSILON as f32;
    let fresh1 = (1.0 - BETA1) as f32;
    let fresh2 = (1.0 - BETA2) as f32;
    let target: &mut [f32] = cast_slice_mut(&mut learned.target[lines.clone()]);
    let online: &mut [f32] = cast_slice_mut(&mut learned.online[lines.clone()]);
    let m: &mut [f32] = cast_slice_mut(&mut learned.m[lines.clone()]);
    let v: &mut [f32] = cast_slice_mut(&mut learned.v[lines]);
    let all =
        target.iter_mut().zip(online).zip(m.iter_mut().zip(v)).zip(cast_slice::<_, f32>(grad));
    Arch::new().dispatch(|| {
        for (((target, x), (m, v)), g) in all {
            *m = decay1 * *m + fresh1 * g;
            *v = decay2 * *v + fresh2 * (g * g);
            *x -= rate * *m / (v.sqrt() * scale + epsilon);
            *target = (1.0 - tau) * *target + tau * *x;
        }
    });
}
