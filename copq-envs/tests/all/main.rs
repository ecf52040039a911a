//! All tests of robots and tasks, in one program.

mod allocations;
mod check;
mod contract;
mod golden;
mod kinematics;
mod mjcf;
mod models;
mod support;
mod tasks;
