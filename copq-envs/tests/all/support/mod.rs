//! Engines by hand: one that stands still, one that plays a recorded run.
#![allow(dead_code, unused_imports)]

mod recording;
mod still;
mod table;

pub use recording::Recording;
pub use still::Still;
pub use table::Table;
