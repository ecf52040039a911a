//! Numbers above a picture.

use copq::Result;
use copq::error::check_len;
use tiny_skia::Pixmap;

use super::text::Pen;
use super::{HEIGHT, WIDTH, rgb, sheet};

const NAME: [u8; 3] = [96, 102, 112];
const VALUE: [u8; 3] = [45, 45, 45];
/// Room to the left and right of the readings, in pixels.
const EDGE: f32 = 24.0;

/// Writes readings.
pub(super) struct Caption {
    pen: Pen,
    sheet: Pixmap,
}

impl Caption {
    pub fn new() -> Result<Self> {
        Ok(Self { pen: Pen::new()?, sheet: sheet()? })
    }

    /// The picture with a row of names and values; red, green and blue of every pixel.
    pub fn write(&mut self, picture: &[u8], readings: &[(String, String)]) -> Result<Vec<u8>> {
        check_len("picture", picture.len(), 3 * (WIDTH * HEIGHT) as usize)?;
        for (pixel, colour) in
            self.sheet.data_mut().chunks_exact_mut(4).zip(picture.chunks_exact(3))
        {
            pixel[..3].copy_from_slice(colour);
            pixel[3] = u8::MAX;
        }
        let column = (WIDTH as f32 - 2.0 * EDGE) / readings.len().max(1) as f32;
        for (index, (name, value)) in readings.iter().enumerate() {
            let left = EDGE + column * index as f32;
            self.pen.write(&mut self.sheet, name, (left, 30.0), 14.0, NAME);
            self.pen.write(&mut self.sheet, value, (left, 54.0), 22.0, VALUE);
        }
        Ok(rgb(&self.sheet))
    }
}
