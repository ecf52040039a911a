//! The fast path for CPUs: flat buffers, matrix products from the `gemm` crate, and everything else in a few passes.
//!
//! A warm update allocates nothing here (the `gemm` crate allocates packing buffers inside its larger products). One
//! thread is the default; [`Critics::threads`] spreads the critics over more, and changes no bit of the result.

mod actor;
mod adam;
mod critics;
mod matmul;
mod network;
mod passes;
mod perceptron;
mod workers;

pub use actor::Deterministic;
pub use critics::Critics;
