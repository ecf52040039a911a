//! The two formats of a figure: SVG text and a PNG image.

use copq::{Error, Result};
use plotters::prelude::{BitMapBackend, IntoDrawingArea, SVGBackend};

use crate::pen::Pen;
use crate::{Figure, font, layout};

/// Device units to a unit of the layout: fine enough that whole numbers of them make smooth lines.
const FINE: u32 = 4;
/// plotters puts the middle of a word right in SVG, and too high by a fifth of its size in bitmaps.
const SINK: f64 = 0.2;
/// Device units to a pixel of the PNG, each way, which smooths edges.
const SMOOTH: u32 = 2;

/// A figure as SVG.
pub(crate) fn svg(figure: &Figure) -> Result<String> {
    font::register();
    let (width, height) = layout::size(figure);
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (width * FINE, height * FINE)).into_drawing_area();
    let pen = Pen { area: &area, scale: f64::from(FINE), sink: 0.0 };
    layout::draw(&pen, figure).map_err(|e| Error::other("drawing an SVG", e.to_string()))?;
    drop(area);
    let fine = format!("width=\"{}\" height=\"{}\"", width * FINE, height * FINE);
    Ok(text.replacen(&fine, &format!("width=\"{width}\" height=\"{height}\""), 1))
}

/// A figure as the bytes of a PNG file, two pixels to a unit of the layout.
pub(crate) fn png(figure: &Figure) -> Result<Vec<u8>> {
    font::register();
    let (width, height) = layout::size(figure);
    let (wide, high) = (width * FINE, height * FINE);
    let mut fine = vec![0; (wide * high * 3) as usize];
    let area = BitMapBackend::with_buffer(&mut fine, (wide, high)).into_drawing_area();
    let pen = Pen { area: &area, scale: f64::from(FINE), sink: SINK };
    layout::draw(&pen, figure).map_err(|e| Error::other("drawing a PNG", e.to_string()))?;
    drop(area);
    encode_png(&shrink(&fine, wide as usize), wide / SMOOTH, high / SMOOTH)
}

/// The mean of each square of fine pixels.
fn shrink(fine: &[u8], wide: usize) -> Vec<u8> {
    let smooth = SMOOTH as usize;
    let mut small = Vec::with_capacity(fine.len() / (smooth * smooth));
    for rows in fine.chunks_exact(wide * 3 * smooth) {
        for byte in (0..wide / smooth).flat_map(|x| (0..3).map(move |colour| x * smooth * 3 + colour)) {
            let square = (0..smooth).flat_map(|y| (0..smooth).map(move |x| (y * wide + x) * 3 + byte));
            let sum: usize = square.map(|i| usize::from(rows[i])).sum();
            small.push((sum / (smooth * smooth)) as u8);
        }
    }
    small
}

/// Red, green and blue of every pixel, row by row, as the bytes of a PNG file.
pub(crate) fn encode_png(pixels: &[u8], width: u32, height: u32) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    written.map_err(|e| Error::other("encoding a PNG", e))?;
    Ok(bytes)
}
