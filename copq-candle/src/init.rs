//! Fresh weights.

use copq::{Initial, Rng};

use crate::shape::Shape;

/// Parameters in the flat buffer's order, drawn as `initial` says. Every one takes its number from `rng`, even a bias that
/// starts from zero.
pub(crate) fn parameters(shape: &Shape, initial: Initial, rng: &mut Rng) -> Vec<f32> {
    let mut out = vec![0.0; shape.len()];
    for layer in shape.layers() {
        let root = 1.0 / libm::sqrt(layer.input as f64);
        let (weight, bias) = match initial {
            Initial::Torch => (root, root),
            Initial::Lecun => (libm::sqrt(3.0) * root, 0.0),
        };
        for (range, bound) in [(layer.weight(), weight), (layer.bias(), bias)] {
            for value in &mut out[range] {
                *value = rng.uniform_in(-bound, bound) as f32;
            }
        }
    }
    out
}
