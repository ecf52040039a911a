//! Pictures as one GIF, with one palette for all.

use color_quant::NeuQuant;
use copq::{Error, Result};
use gif::{Encoder, EncodingError, Frame, Repeat};

/// The palette is learnt from one in this many pixels.
const SAMPLE: i32 = 7;
const COLOURS: usize = 256;

/// The bytes of a GIF file: pictures of one size, each shown for its delay in hundredths of a
/// second. `picture` draws one of them: red, green and blue of every pixel, row by row.
pub(crate) fn encode(
    [width, height]: [u32; 2],
    delays: &[u64],
    picture: &mut dyn FnMut(usize) -> Result<Vec<u8>>,
) -> Result<Vec<u8>> {
    let palette = palette(delays.len(), picture)?;
    let mut bytes = Vec::new();
    let failed = |e: EncodingError| Error::other("encoding a GIF", e);
    let width = width as u16;
    let height = height as u16;
    let mut encoder =
        Encoder::new(&mut bytes, width, height, &palette.color_map_rgb()).map_err(failed)?;
    encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
    for (i, &delay) in delays.iter().enumerate() {
        let buffer = opaque(&picture(i)?).map(|pixel| palette.index_of(&pixel) as u8).collect();
        let delay = u16::try_from(delay).unwrap_or(u16::MAX);
        encoder
            .write_frame(&Frame { width, height, delay, buffer, ..Frame::default() })
            .map_err(failed)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// The colours of the first, the middle and the last picture.
fn palette(count: usize, picture: &mut dyn FnMut(usize) -> Result<Vec<u8>>) -> Result<NeuQuant> {
    let last = count - 1;
    let mut pixels = Vec::new();
    for index in [0, last / 2, last] {
        pixels.extend(opaque(&picture(index)?).flatten());
    }
    Ok(NeuQuant::new(SAMPLE, COLOURS, &pixels))
}

/// Red, green and blue with an opacity of one.
fn opaque(pixels: &[u8]) -> impl Iterator<Item = [u8; 4]> {
    pixels.as_chunks::<3>().0.iter().map(|&[red, green, blue]| [red, green, blue, 255])
}
