//! Smooth activations and their slopes, as passes over a layer's outputs; ReLU is part of the
//! product.
//!
//! Every value takes the same additions, fused multiply-adds and one division, in vectors as wide
//! as the processor has. Its bits do not depend on that width.

use bytemuck::{cast_slice, cast_slice_mut};
use copq::Activation;
use pulp::Arch;

use super::panels::Panels;

/// Beyond this, tanh is 1 to within 3e-7.
const SATURATED: f32 = 7.905_311;

/// tanh(x) as x P(x^2) / Q(x^2), from the highest power down: the minimax fit that Eigen uses for
/// f32.
const P: [f32; 7] = [
    -2.760_768_5e-16,
    2.000_188e-13,
    -8.604_672e-11,
    5.122_297_1e-8,
    1.485_722_4e-5,
    6.372_619_3e-4,
    4.893_524_6e-3,
];
const Q: [f32; 4] = [1.198_258_4e-6, 1.185_347_1e-4, 2.268_434_6e-3, 4.893_525e-3];

/// Applies the activation to a layer's outputs, and writes its slopes if they are wanted. ReLU has
/// already been applied.
pub(super) fn activate(activation: Activation, out: &mut Panels, slopes: Option<&mut Panels>) {
    match activation {
        Activation::Relu => {}
        Activation::Tanh => each(out, slopes, tanh_and_slope),
        Activation::Silu => each(out, slopes, silu_and_slope),
    }
}

/// `values <- values * by`, element by element.
pub(super) fn multiply(values: &mut Panels, by: &Panels) {
    let values: &mut [f32] = cast_slice_mut(values.lines_mut());
    let by: &[f32] = cast_slice(by.lines());
    Arch::new().dispatch(|| values.iter_mut().zip(by).for_each(|(value, by)| *value *= by));
}

#[inline(always)]
fn each(out: &mut Panels, slopes: Option<&mut Panels>, function: impl Fn(f32) -> (f32, f32)) {
    let rows = out.rows();
    let cols = out.cols();
    let values: &mut [f32] = cast_slice_mut(out.lines_mut());
    Arch::new().dispatch(
        #[inline(always)]
        || match slopes {
            None => values.iter_mut().for_each(|x| *x = function(*x).0),
            Some(slopes) => {
                let slopes: &mut [f32] = cast_slice_mut(slopes.reshape(rows, cols));
                values.iter_mut().zip(slopes).for_each(|(x, slope)| (*x, *slope) = function(*x));
            }
        },
    );
}

/// tanh to within 3.4e-7, exactly 1 or -1 far out. A NaN stays a NaN.
#[inline(always)]
fn tanh(x: f32) -> f32 {
    let square = x * x;
    let powers =
        |coefficients: &[f32]| coefficients.iter().fold(0.0, |sum: f32, &c| sum.mul_add(square, c));
    let fit = x * powers(&P) / powers(&Q);
    if x.abs() > SATURATED { 1.0f32.copysign(x) } else { fit }
}

#[inline(always)]
fn tanh_and_slope(x: f32) -> (f32, f32) {
    let y = tanh(x);
    (y, 1.0 - y * y)
}

/// x s and its slope s + x s (1 - s), where s = 1 / (1 + exp(-x)) = (1 + tanh(x / 2)) / 2.
#[inline(always)]
fn silu_and_slope(x: f32) -> (f32, f32) {
    let s = 0.5 + 0.5 * tanh(0.5 * x);
    let y = x * s;
    (y, s + y * (1.0 - s))
}

#[cfg(test)]
mod tests {
    use approx::abs_diff_eq;

    use super::*;

    /// Values of every size and sign, and the special ones.
    fn inputs() -> Vec<f32> {
        let sizes = (-100..40).map(|power| 1.5f32.powi(power));
        let fine = (0..4000).map(|i| i as f32 * 0.005);
        let positive: Vec<f32> =
            sizes.chain(fine).chain([f32::MAX, f32::INFINITY, f32::MIN_POSITIVE]).collect();
        positive.iter().flat_map(|&x| [x, -x]).collect()
    }

    fn run(activation: Activation, inputs: &[f32]) -> [Vec<f32>; 2] {
        let mut out = Panels::default();
        let mut slopes = Panels::default();
        out.set(inputs.len(), &[inputs]);
        activate(activation, &mut out, Some(&mut slopes));
        [out, slopes].map(|panels| {
            let mut dense = vec![0.0; inputs.len()];
            panels.get(0, &mut dense);
            dense
        })
    }

    #[test]
    fn they_are_their_definitions_in_double_precision() {
        let inputs = inputs();
        let [tanh, tanh_slope] = run(Activation::Tanh, &inputs);
        let [silu, silu_slope] = run(Activation::Silu, &inputs);
        for (i, &x) in inputs.iter().enumerate().filter(|(_, x)| x.is_finite()) {
            let x = f64::from(x);
            let check = |what: &str, got: f32, wanted: f64, tolerance: f64| {
                let close = abs_diff_eq!(f64::from(got), wanted, epsilon = tolerance);
                assert!(close, "{what}({x}) = {got}, not {wanted}");
            };
            let wanted = libm::tanh(x);
            check("tanh", tanh[i], wanted, 3.4e-7 * wanted.abs() + 1e-37);
            check("tanh'", tanh_slope[i], 1.0 - wanted * wanted, 7e-7);
            let s = 1.0 / (1.0 + libm::exp(-x));
            check("silu", silu[i], x * s, 3e-7 * x.abs());
            let slope = s + x * s * (1.0 - s);
            check("silu'", silu_slope[i], slope, 1e-6 * (1.0 + x.abs().min(10.0)));
        }
    }

    #[test]
    fn tanh_is_odd_never_above_one_and_keeps_nan() {
        let inputs = inputs();
        let [tanh, slope] = run(Activation::Tanh, &inputs);
        for pair in tanh.chunks_exact(2) {
            assert_eq!(pair[0], -pair[1]);
            assert!(pair[0] <= 1.0);
        }
        assert!(slope.iter().all(|&slope| slope >= 0.0));
        for activation in [Activation::Tanh, Activation::Silu] {
            assert!(run(activation, &[f32::NAN])[0][0].is_nan());
        }
    }

    /// Vectors of this processor against one value at a time by the compiler's plain target.
    #[test]
    fn vectors_give_the_bits_of_single_values() {
        let inputs = inputs();
        let bits = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        for (activation, function) in [
            (Activation::Tanh, tanh_and_slope as fn(f32) -> (f32, f32)),
            (Activation::Silu, silu_and_slope),
        ] {
            let [values, slopes] = run(activation, &inputs);
            let (wanted, wanted_slopes): (Vec<f32>, Vec<f32>) =
                inputs.iter().map(|&x| function(x)).unzip();
            assert_eq!((bits(&values), bits(&slopes)), (bits(&wanted), bits(&wanted_slopes)));
        }
    }
}
