//! The letters of figures, embedded so that no font need be installed. (`fonts/LICENSE.txt`)

/// The name that figures use; viewers of SVG put their own sans-serif in its place.
pub(crate) const FAMILY: &str = "sans-serif";

pub(crate) static DEJAVU_SANS: &[u8] = include_bytes!("../fonts/DejaVuSans-subset.ttf");
