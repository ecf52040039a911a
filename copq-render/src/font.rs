//! The font of figures, embedded so that none need be installed. (`fonts/LICENSE.txt`)

use ab_glyph::{Font, FontRef};

/// The name that figures use; SVG viewers put their own sans-serif font in its place.
pub(crate) const FAMILY: &str = "sans-serif";

pub(crate) static DEJAVU_SANS: &[u8] = include_bytes!("../fonts/DejaVuSans-subset.ttf");

/// The letters of a text that PNG and GIF cannot show, each once. The embedded font has the letters
/// of European languages. SVG contains the text itself, and its viewers have more fonts.
///
/// ```
/// assert_eq!(copq_render::missing_letters("Sécurité, 100 %"), "");
/// assert_eq!(copq_render::missing_letters("速度 and 速さ"), "速度さ");
/// ```
pub fn missing_letters(text: &str) -> String {
    let mut missing = String::new();
    // Without a font every letter is missing, and nothing would have been drawn at all.
    let font = FontRef::try_from_slice(DEJAVU_SANS).ok();
    for letter in text.chars().filter(|letter| !letter.is_control()) {
        let is_known = font.as_ref().is_some_and(|font| font.glyph_id(letter).0 != 0);
        if !is_known && !missing.contains(letter) {
            missing.push(letter);
        }
    }
    missing
}
