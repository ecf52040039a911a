//! Whole runs of a point mass: what they leave behind, and that no stop of any kind changes it.

mod children;
mod contents;
mod events;
mod failures;
mod point_mass;
mod resume;
