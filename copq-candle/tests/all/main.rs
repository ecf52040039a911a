//! All tests of the networks, in one program.

mod allocations;
mod checkpoint;
mod common;
mod errors;
mod exploration;
mod fused_equals_plain;
mod gaussian;
mod gradients;
mod methods;
mod modules;
mod on_policy;
mod precision;
mod pytorch;
