//! What crosses the crates, but for the engines side by side.

mod kinematics;
mod on_policy;
mod onnx;
mod python;
mod python_examples;
mod quick_start;
mod results;
mod resume;
