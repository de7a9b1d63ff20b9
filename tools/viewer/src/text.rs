//! Words on a picture, in pixels, drawn from outlines that come with a crate: a machine without fonts draws the same letters.

use ab_glyph::{Font, FontRef, Point, ScaleFont, point};

use crate::image::Image;

/// The font.
fn font() -> Option<FontRef<'static>> {
    FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).ok()
}

/// Writes `text` from (`x`, `y`), the left end of its baseline \[pixels\], in a colour as in a file (sRGB).
pub fn write(image: &mut Image, text: &str, x: f32, y: f32, size: f32, colour: [u8; 3]) {
    let Some(font) = font() else { return };
    let mut pen = point(x, y);
    for c in text.chars() {
        let id = font.glyph_id(c);
        let glyph = id.with_scale_and_position(size, pen);
        if let Some(outline) = font.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            // a light face: covered a little more than it says, to be read on any ground
            outline.draw(|i, j, cover| blend(image, corner, i, j, colour, (1.25 * cover).min(1.0)));
        }
        pen.x += font.as_scaled(size).h_advance(id);
    }
}

/// A filled rectangle \[pixels\].
pub fn fill(image: &mut Image, corner: (f32, f32), size: (f32, f32), colour: [u8; 3], cover: f32) {
    for j in 0..size.1 as u32 {
        for i in 0..size.0 as u32 {
            blend(image, point(corner.0, corner.1), i, j, colour, cover);
        }
    }
}

fn blend(image: &mut Image, corner: Point, i: u32, j: u32, colour: [u8; 3], cover: f32) {
    let (x, y) = (corner.x as i64 + i64::from(i), corner.y as i64 + i64::from(j));
    if x < 0 || y < 0 || x >= i64::from(image.width) || y >= i64::from(image.height) {
        return;
    }
    let at = 3 * (y as usize * image.width as usize + x as usize);
    for (old, new) in image.rgb[at..at + 3].iter_mut().zip(colour) {
        *old = (f32::from(*old) * (1.0 - cover) + f32::from(new) * cover).round() as u8;
    }
}
