//! Fresh weights, drawn as PyTorch's `nn.Linear` draws them.

use copq::Rng;

use crate::shape::Shape;

/// Weights and biases uniform on +-1/sqrt(inputs of the layer), in the flat buffer's order (TD3's reference code).
pub(crate) fn parameters(shape: &Shape, rng: &mut Rng) -> Vec<f32> {
    let mut out = vec![0.0; shape.len()];
    for layer in shape.layers() {
        let bound = 1.0 / libm::sqrt(layer.input as f64);
        for value in &mut out[layer.weight().start..layer.bias().end] {
            *value = rng.uniform_in(-bound, bound) as f32;
        }
    }
    out
}
