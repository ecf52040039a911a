//! Adam and Polyak averaging in one pass over parameters.

use pulp::{Arch, Simd, WithSimd};

use super::gradient::Descent;
use super::panels::PanelRow;
use crate::adam::{BETA1, BETA2, EPSILON, Step};

/// The constants of one step, and how far targets follow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Adam {
    rate: f32,
    scale: f32,
    tau: f32,
}

impl Adam {
    /// The constants of the `steps`-th step, counted from 1.
    pub fn new(lr: f64, steps: u64, tau: f32) -> Self {
        let Step { rate, root } = Step::new(lr, steps);
        Self { rate: rate as f32, scale: (1.0 / root) as f32, tau }
    }

    /// Steps some parameters, their targets and both moments against a gradient.
    #[inline(always)]
    pub fn step<S: Simd>(&self, simd: S, grad: S::f32s, at: [&mut S::f32s; 4]) {
        let [online, target, m, v] = at;
        let times = |x: f32, y: S::f32s| simd.mul_f32s(simd.splat_f32s(x), y);
        let square = simd.mul_f32s(grad, grad);
        *m = simd.add_f32s(times(BETA1 as f32, *m), times((1.0 - BETA1) as f32, grad));
        *m = flushed(simd, *m);
        *v = simd.add_f32s(times(BETA2 as f32, *v), times((1.0 - BETA2) as f32, square));
        *v = flushed(simd, *v);
        let root = simd.mul_f32s(simd.sqrt_f32s(*v), simd.splat_f32s(self.scale));
        let divisor = simd.add_f32s(root, simd.splat_f32s(EPSILON as f32));
        *online = simd.sub_f32s(*online, simd.div_f32s(times(self.rate, *m), divisor));
        *target = simd.add_f32s(times(1.0 - self.tau, *target), times(self.tau, *online));
    }
}

/// Replaces subnormal numbers by zero. A moment that no gradient feeds would stop shrinking there,
/// and many processors are slow with such numbers.
#[inline(always)]
fn flushed<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let is_small = simd.less_than_f32s(simd.abs_f32s(x), simd.splat_f32s(f32::MIN_POSITIVE));
    simd.select_f32s(is_small, simd.splat_f32s(0.0), x)
}

/// Steps a map against a gradient in memory.
pub(super) fn step(map: Descent<'_>, grad: &[PanelRow]) {
    Arch::new().dispatch(Whole { map, grad });
}

struct Whole<'a> {
    map: Descent<'a>,
    grad: &'a [PanelRow],
}

impl WithSimd for Whole<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Descent { online, target, m, v, adam } = self.map;
        let [online, target, m, v] = [online, target, m, v]
            .map(|lines| S::as_mut_simd_f32s(bytemuck::cast_slice_mut(lines)).0);
        let grad = S::as_simd_f32s(bytemuck::cast_slice(self.grad)).0;
        let all = online.iter_mut().zip(target).zip(m.iter_mut().zip(v)).zip(grad);
        for (((online, target), (m, v)), &grad) in all {
            adam.step(simd, grad, [online, target, m, v]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::panels::WIDTH;
    use super::*;

    #[test]
    fn moments_that_no_gradient_feeds_end_at_zero() {
        let small = f32::MIN_POSITIVE;
        let after = |m: f32, v: f32| {
            let line = |x| [PanelRow([x; WIDTH])];
            let [mut online, mut target, mut m, mut v] = [line(1.0), line(1.0), line(m), line(v)];
            let map = Descent {
                online: &mut online,
                target: &mut target,
                m: &mut m,
                v: &mut v,
                adam: Adam::new(1e-3, 7, 0.0),
            };
            step(map, &line(0.0));
            [m[0].0[3], v[0].0[3]]
        };
        assert_eq!(after(small, small), [0.0, 0.0]);
        assert_eq!(after(-small, 0.0), [0.0, 0.0]);
        let [m, v] = after(-2.0 * small, 2.0 * small);
        assert!(m < -small && v > small, "{m} {v}");
        assert!(after(f32::NAN, f32::NAN).iter().all(|moment| moment.is_nan()));
    }
}
