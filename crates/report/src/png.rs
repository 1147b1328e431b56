//! From SVG to PNG, with a font that comes with the program: the same picture on every machine.

use resvg::{tiny_skia, usvg};

use crate::error::ReportError;
use crate::outline::outlined;

/// Pixels per SVG unit: figures are 640 units wide, so pictures have 1600 pixels, 240 per inch.
const SCALE: f32 = 2.5;

/// The picture of an SVG text, as the bytes of a PNG file; no font of the machine is used. Its texts are understood as
/// far as figures have them: on one line, with place, size, weight, colour and anchor.
///
/// # Errors
/// The text is no SVG, its size cannot be drawn, or the PNG cannot be written.
pub fn png(svg: &str) -> Result<Vec<u8>, ReportError> {
    let refuse = |error: usvg::Error| ReportError::NotDrawable {
        reason: error.to_string(),
    };
    let tree = usvg::Tree::from_str(&outlined(svg)?, &usvg::Options::default());
    let tree = tree.map_err(refuse)?;
    let width = (tree.size().width() * SCALE).ceil() as u32;
    let height = (tree.size().height() * SCALE).ceil() as u32;
    let mut pixels =
        tiny_skia::Pixmap::new(width, height).ok_or(ReportError::Size { width, height })?;
    resvg::render(
        &tree,
        tiny_skia::Transform::from_scale(SCALE, SCALE),
        &mut pixels.as_mut(),
    );
    pixels.encode_png().map_err(|error| ReportError::Encoding {
        reason: error.to_string(),
    })
}
