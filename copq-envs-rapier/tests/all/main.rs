//! All tests of rapier as the engine, in one program.

mod contacts;
mod flight;
mod friction;
mod joints;
mod landing;
mod model;
mod random_actions;
mod refusals;
mod reset;
mod snapshot;
mod support;
mod world;
