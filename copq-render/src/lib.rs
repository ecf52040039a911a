//! Pictures for copq: curves with bands as SVG and PNG ([`Figure`]), and robots in motion
//! ([`animation`]).
//!
//! ```
//! use copq_render::{Figure, Panel, Point, Series};
//!
//! let points = (0..5).map(|i| Point::within(f64::from(i), 2.0 * f64::from(i), 0.5)).collect();
//! let panel = Panel::new("return").series(Series::new("cholesky", points));
//! let figure = Figure::new("A first figure", "Line: mean. Band: half a unit.").panel(panel);
//! assert!(figure.svg()?.starts_with("<svg"));
//! # Ok::<(), copq::Error>(())
//! ```

pub mod animation;
mod canvas;
mod figure;
mod font;
mod layout;
mod panel;
mod pen;
mod plane;
mod ticks;

pub(crate) use canvas::encode_png;
pub use figure::{Figure, Panel, Point, Series};
pub(crate) use font::DEJAVU_SANS;
pub use font::missing_letters;
pub(crate) use layout::colour;
pub use layout::label_sample;
pub use plane::Plane;
