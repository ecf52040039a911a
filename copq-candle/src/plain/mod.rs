//! The readable path: candle's tensors and autograd on any device, the oracle for the fused one.

mod actor;
mod critics;
mod gaussian;
mod network;
mod policy;

pub use actor::Deterministic;
pub use critics::Critics;
pub use gaussian::Gaussian;

use candle_core::Tensor;
use copq::{Error, Result};
pub(crate) use network::values;

/// A failure inside candle as copq's error.
pub(crate) fn failed(error: candle_core::Error) -> Error {
    Error::other("candle", error)
}

/// Shown an output's values, fills the loss's gradient to them.
pub(crate) type Fill<'a> = &'a mut dyn FnMut(&[f32], &mut [f32]) -> Result<()>;

/// A loss whose gradient to `output` is what `fill` makes of its values: sum(output * gradient), the gradient a constant.
pub(crate) fn loss_of(output: &Tensor, fill: Fill<'_>) -> Result<Tensor> {
    let shown = values(output).map_err(failed)?;
    let mut gradient = vec![0.0; shown.len()];
    fill(&shown, &mut gradient)?;
    let gradient = Tensor::from_vec(gradient, output.dims(), output.device()).map_err(failed)?;
    (output * gradient).and_then(|product| product.sum_all()).map_err(failed)
}
