//! Words on a picture.

use ab_glyph::{Font, FontRef, OutlinedGlyph, ScaleFont, point};
use copq::{Error, Result};
use tiny_skia::Pixmap;

use crate::DEJAVU_SANS;

/// Writes in the font of the figures.
pub(super) struct Pen {
    font: FontRef<'static>,
}

impl Pen {
    pub fn new() -> Result<Self> {
        let font = FontRef::try_from_slice(DEJAVU_SANS)
            .map_err(|e| Error::other("reading the font", e))?;
        Ok(Self { font })
    }

    /// Writes a line from a point on its baseline; `size` in pixels.
    pub fn write(
        &self,
        sheet: &mut Pixmap,
        text: &str,
        (mut x, y): (f32, f32),
        size: f32,
        colour: [u8; 3],
    ) {
        let font = self.font.as_scaled(size);
        for letter in text.chars() {
            let mut glyph = font.scaled_glyph(letter);
            glyph.position = point(x, y);
            x += font.h_advance(glyph.id);
            if let Some(outline) = self.font.outline_glyph(glyph) {
                print(sheet, &outline, colour);
            }
        }
    }
}

/// Mixes the colour into the pixels that a letter covers.
fn print(sheet: &mut Pixmap, letter: &OutlinedGlyph, colour: [u8; 3]) {
    let width = sheet.width() as i32;
    let height = sheet.height() as i32;
    let corner = letter.px_bounds().min;
    letter.draw(|x, y, coverage| {
        let x = corner.x as i32 + x as i32;
        let y = corner.y as i32 + y as i32;
        if (0..width).contains(&x) && (0..height).contains(&y) {
            let at = 4 * (y * width + x) as usize;
            for (pixel, ink) in sheet.data_mut()[at..at + 3].iter_mut().zip(colour) {
                *pixel = (f32::from(*pixel) * (1.0 - coverage) + f32::from(ink) * coverage).round()
                    as u8;
            }
        }
    });
}
