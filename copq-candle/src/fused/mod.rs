//! The fast path for CPUs: networks whose parameters and activations lie in the order in which the
//! matrix products read them.
//!
//! Bias and activation, forward and backward, and the optimiser's step down a gradient are applied
//! to a product's results while they are still in registers. Everything else is a few passes over
//! memory. A warm update on one thread allocates nothing, except for natural gradients. One thread
//! is the default. [`Critics::threads`] spreads the critics over more; [`Deterministic::threads`]
//! and [`Gaussian::threads`] spread an actor's products, except the last layer's. Threads change no
//! bit of the result. Nor does the processor: each sum is taken in one order, products by fused
//! multiply-adds, whatever the width of its vectors.

mod activation;
mod actor;
mod adam;
mod body;
mod critics;
mod gaussian;
mod gradient;
mod half;
mod kept;
mod last;
mod layout;
#[cfg(test)]
mod matrices;
mod network;
mod normal;
mod panels;
mod passes;
mod product;
mod threads;
mod tiles;
mod transpose;
mod value;
mod workers;
mod workspace;

pub use actor::Deterministic;
pub use critics::Critics;
pub use gaussian::Gaussian;
pub use normal::Normal;
pub use value::Value;
