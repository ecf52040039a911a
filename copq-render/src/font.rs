//! The letters of bitmap figures, embedded so that no font need be installed. (`fonts/LICENSE.txt`)

use std::sync::Once;

use plotters::style::{FontStyle, register_font};

/// The name that figures use; viewers of SVG put their own sans-serif in its place.
pub(crate) const FAMILY: &str = "sans-serif";

pub(crate) static DEJAVU_SANS: &[u8] = include_bytes!("../fonts/DejaVuSans-subset.ttf");

/// Makes the font known to plotters, once.
pub(crate) fn register() {
    static ONCE: Once = Once::new();
    // A font that could not be read shows as an error at the first text that is drawn.
    ONCE.call_once(|| drop(register_font(FAMILY, FontStyle::Normal, DEJAVU_SANS)));
}
