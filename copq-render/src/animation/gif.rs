//! The frames as one GIF, with one palette for all.

use color_quant::NeuQuant;
use copq::{Error, Result};
use gif::{Encoder, EncodingError, Frame, Repeat};

use super::{Animation, Draw, HEIGHT, Scene, WIDTH};

/// One of so many pixels teaches the palette.
const SAMPLE: i32 = 7;
const COLOURS: usize = 256;

/// The bytes of a GIF file.
pub(super) fn encode(animation: &Animation, draw: &mut Draw<'_>) -> Result<Vec<u8>> {
    let mut picture = animation.pictures(draw)?;
    let palette = palette(animation, &mut picture)?;
    let mut bytes = Vec::new();
    let failed = |e: EncodingError| Error::other("encoding a GIF", e);
    let width = WIDTH as u16;
    let height = HEIGHT as u16;
    let mut encoder =
        Encoder::new(&mut bytes, width, height, &palette.color_map_rgb()).map_err(failed)?;
    encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
    for (frame, delay) in animation.frames.iter().zip(animation.delays()) {
        let buffer =
            opaque(&picture(&frame.scene)?).map(|pixel| palette.index_of(&pixel) as u8).collect();
        let delay = u16::try_from(delay).unwrap_or(u16::MAX);
        encoder
            .write_frame(&Frame { width, height, delay, buffer, ..Frame::default() })
            .map_err(failed)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// The colours of the first, the middle and the last frame.
fn palette(
    animation: &Animation,
    picture: &mut impl FnMut(&Scene) -> Result<Vec<u8>>,
) -> Result<NeuQuant> {
    let last = animation.frames.len() - 1;
    let mut pixels = Vec::new();
    for index in [0, last / 2, last] {
        pixels.extend(opaque(&picture(&animation.frames[index].scene)?).flatten());
    }
    Ok(NeuQuant::new(SAMPLE, COLOURS, &pixels))
}

/// Red, green and blue with an opacity of one.
fn opaque(pixels: &[u8]) -> impl Iterator<Item = [u8; 4]> {
    pixels.as_chunks::<3>().0.iter().map(|&[red, green, blue]| [red, green, blue, 255])
}
