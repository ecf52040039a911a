//! The fast path for CPUs: flat buffers, matrix products from the `gemm` crate, and everything else in a few passes.
//!
//! A warm update on one thread allocates nothing here; the `gemm` crate makes packing buffers, one or two allocations a
//! product. One thread is the default; [`Critics::threads`] spreads the critics over more, and changes no bit of the
//! result. The same bits come back on the same kind of processor: `gemm` chooses its kernels, and so its order of
//! summation, by what the processor has.

mod actor;
mod adam;
mod critics;
mod gaussian;
#[allow(unsafe_code)] // The one call into `gemm`, behind checked shapes.
mod matmul;
mod network;
mod passes;
mod perceptron;
mod policy;
mod workers;

pub use actor::Deterministic;
pub use critics::Critics;
pub use gaussian::Gaussian;
