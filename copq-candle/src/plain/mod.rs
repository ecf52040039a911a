//! The readable path: candle's tensors and autograd on any device, the oracle for the fused one.

mod actor;
mod critics;
mod gaussian;
mod network;
mod policy;

pub use actor::Deterministic;
pub use critics::Critics;
pub use gaussian::Gaussian;

use copq::Error;

/// A failure inside candle as copq's error.
fn failed(error: candle_core::Error) -> Error {
    Error::other("candle", error)
}
