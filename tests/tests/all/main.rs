//! What crosses the crates, but for the engines side by side.

mod kinematics;
mod quick_start;
mod results;
mod resume;
