//! Fresh weights.

use copq::{Init, Rng};

use crate::shape::Shape;

/// Parameters in the flat buffer's order, drawn as `initial` says. Every parameter takes a number
/// from `rng`, even a bias that starts from zero.
pub(crate) fn parameters(shape: &Shape, initial: Init, rng: &mut Rng) -> Vec<f32> {
    let mut out = vec![0.0; shape.len()];
    for layer in shape.layers() {
        let root = 1.0 / libm::sqrt(layer.input as f64);
        let (weight, bias) = match initial {
            Init::Torch => (root, root),
            Init::Lecun => (libm::sqrt(3.0) * root, 0.0),
        };
        for (range, bound) in [(layer.weight(), weight), (layer.bias(), bias)] {
            for value in &mut out[range] {
                *value = rng.uniform_in(-bound, bound) as f32;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use approx::abs_diff_eq;
    use copq::Stream;

    use super::*;

    /// Largest weight and bias of 200 inputs' layer, and the weights' variance, of both rules.
    #[test]
    fn weights_have_their_rules_bounds_and_variance() {
        let shape = Shape::new(200, &[100], 50);
        for (initial, bound, bias) in
            [(Init::Torch, 0.005f64.sqrt(), 0.005f64.sqrt()), (Init::Lecun, 0.015f64.sqrt(), 0.0)]
        {
            let values = parameters(&shape, initial, &mut Rng::new(1, Stream::Init));
            let layer = &shape.layers()[0];
            let largest = |range: std::ops::Range<usize>| {
                values[range].iter().fold(0.0f64, |most, &x| most.max(f64::from(x).abs()))
            };
            let weights = &values[layer.weight()];
            let variance =
                weights.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>() / weights.len() as f64;
            assert!((0.99 * bound..=bound).contains(&largest(layer.weight())), "{initial:?}");
            let share = variance / (bound * bound / 3.0);
            assert!(abs_diff_eq!(share, 1.0, epsilon = 0.03), "{initial:?}: {share}");
            assert!((0.9 * bias..=bias).contains(&largest(layer.bias())), "{initial:?}");
        }
    }
}
