//! Pictures that were drawn elsewhere.

use std::io::Cursor;

use copq::error::check_len;
use copq::{Error, Result};
use tiny_skia::{FilterQuality, IntSize, Pixmap, PixmapPaint, Transform};

use super::{HEIGHT, WIDTH, rgb, sheet};
use crate::encode_png;

/// Room for the readings above a picture, in pixels.
const TOP: f32 = 64.0;

/// Pictures of any size as an [`Animation`](super::Animation) shows them. Each is a scene's
/// position, and fills the space that the readings leave.
///
/// ```
/// use copq_render::animation::{Album, HEIGHT, WIDTH};
///
/// let mut album = Album::default();
/// let position = album.add([2, 1], &[255, 0, 0, 0, 0, 255])?; // a red pixel and a blue one
/// assert_eq!(album.draw(&position)?.len(), 3 * (WIDTH * HEIGHT) as usize);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Album {
    /// PNGs, because the frames of an episode are many and much alike.
    pages: Vec<Vec<u8>>,
}

impl Album {
    /// Adds a picture with this width and height in pixels: red, green and blue of each, row by row
    /// from the top. Returns the position of a scene that shows it.
    pub fn add(&mut self, [width, height]: [u32; 2], picture: &[u8]) -> Result<Vec<f64>> {
        check_len("picture", picture.len(), 3 * width as usize * height as usize)?;
        let page = fitted([width, height], picture)?;
        self.pages.push(encode_png(&page, WIDTH, HEIGHT)?);
        Ok(vec![(self.pages.len() - 1) as f64])
    }

    /// The picture of a position that [`Album::add`] returned, as [`Draw`](super::Draw) returns it.
    pub fn draw(&self, position: &[f64]) -> Result<Vec<u8>> {
        let page = position.first().and_then(|&index| self.pages.get(index as usize));
        let wanted = format!("one of {} pictures", self.pages.len());
        let page = page.ok_or_else(|| {
            Error::invalid("position in an album", wanted, format!("{position:?}"))
        })?;
        let failed = |e| Error::other("reading a picture back", e);
        let mut reader = png::Decoder::new(Cursor::new(page)).read_info().map_err(failed)?;
        let mut pixels = vec![0; 3 * (WIDTH * HEIGHT) as usize];
        reader.next_frame(&mut pixels).map_err(failed)?;
        Ok(pixels)
    }
}

/// A picture in the middle of a white sheet, as large as fits.
fn fitted([width, height]: [u32; 2], picture: &[u8]) -> Result<Vec<u8>> {
    let nothing = || Error::invalid("picture", "a width and height", "none");
    let size = IntSize::from_wh(width, height).ok_or_else(nothing)?;
    let pixels = picture.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], u8::MAX]);
    let picture = Pixmap::from_vec(pixels.collect(), size).ok_or_else(nothing)?;
    let mut page = sheet()?;
    page.fill(tiny_skia::Color::WHITE);
    let room = [WIDTH as f32, HEIGHT as f32 - TOP];
    let scale = (room[0] / width as f32).min(room[1] / height as f32);
    let left = 0.5 * (room[0] - scale * width as f32);
    let top = TOP + 0.5 * (room[1] - scale * height as f32);
    let place = Transform::from_row(scale, 0.0, 0.0, scale, left, top);
    let paint = PixmapPaint { quality: FilterQuality::Bilinear, ..PixmapPaint::default() };
    page.draw_pixmap(0, 0, picture.as_ref(), &paint, place, None);
    Ok(rgb(&page))
}
