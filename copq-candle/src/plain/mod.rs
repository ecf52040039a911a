//! The readable path: candle-nn modules and autograd on any device. It is the oracle for the fused
//! path, and your own architectures run on it.

mod actor;
mod body;
mod critics;
mod gaussian;
mod network;
mod perceptron;
mod seeded;

pub use actor::Deterministic;
pub use critics::Critics;
pub use gaussian::Gaussian;

use candle_core::Tensor;
use copq::{Error, Result};

/// A failure inside candle as copq's error.
fn failed(error: candle_core::Error) -> Error {
    Error::other("candle", error)
}

/// A tensor's values in row-major order.
fn values(tensor: &Tensor) -> candle_core::Result<Vec<f32>> {
    tensor.flatten_all()?.to_vec1()
}

/// An error unless a module has returned `rows x width` numbers.
fn check_output(what: &str, output: &Tensor, rows: usize, width: usize) -> Result<()> {
    let wanted = [rows, width];
    if output.dims() == wanted {
        return Ok(());
    }
    Err(Error::invalid(what, format!("dimensions {wanted:?}"), format!("{:?}", output.dims())))
}

/// Given an output's values, fills the loss's gradient with respect to them.
type Fill<'a> = &'a mut dyn FnMut(&[f32], &mut [f32]) -> Result<()>;

/// A loss whose gradient with respect to `output` is what `fill` computes from its values:
/// sum(output * gradient), with the gradient as a constant.
fn loss_of(output: &Tensor, fill: Fill<'_>) -> Result<Tensor> {
    let shown = values(output).map_err(failed)?;
    let mut gradient = vec![0.0; shown.len()];
    fill(&shown, &mut gradient)?;
    let gradient = Tensor::from_vec(gradient, output.dims(), output.device()).map_err(failed)?;
    (output * gradient).and_then(|product| product.sum_all()).map_err(failed)
}
