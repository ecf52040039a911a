//! From SVG to pixels.

use std::path::Path;
use std::sync::Arc;

use copq::{Error, Result, files};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::{Database, Source};
use resvg::usvg::{Options, Tree};

use crate::font::DEJAVU_SANS;

/// Pixels per unit of the layout.
const SCALE: f32 = 2.0;

/// An opaque SVG as the bytes of a PNG file, two pixels per unit.
pub(crate) fn rasterise(svg: &str) -> Result<Vec<u8>> {
    let (width, height, pixels) = pixels(svg)?;
    encode_png(&pixels, width, height)
}

/// Writes an SVG to a file, whose ending decides the format: `.svg` or `.png`.
pub(crate) fn write(path: &Path, svg: &str) -> Result<()> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("svg") => files::replace(path, svg.as_bytes()),
        Some("png") => files::replace(path, &rasterise(svg)?),
        _ => {
            let wanted = "a name that ends in .svg or .png";
            Err(Error::invalid("figure's file", wanted, path.display()))
        }
    }
}

/// An opaque SVG as red, green and blue of every pixel, row by row, two pixels per unit; width and
/// height first.
pub(crate) fn pixels(svg: &str) -> Result<(u32, u32, Vec<u8>)> {
    let mut fonts = Database::new();
    fonts.load_font_source(Source::Binary(Arc::new(DEJAVU_SANS)));
    let family = fonts.faces().next().and_then(|face| Some(face.families.first()?.0.clone()));
    fonts.set_sans_serif_family(family.unwrap_or_default());
    let options = Options { fontdb: Arc::new(fonts), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|e| Error::other("drawing a PNG", e))?;
    let size = tree.size().to_int_size().scale_by(SCALE).ok_or_else(empty)?;
    let mut sheet = Pixmap::new(size.width(), size.height()).ok_or_else(empty)?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut sheet.as_mut());
    let pixels = sheet.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    Ok((size.width(), size.height(), pixels))
}

fn empty() -> Error {
    Error::invalid("a figure's size", "at least one pixel", "none")
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
