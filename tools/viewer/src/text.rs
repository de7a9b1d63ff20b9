//! Words and signs on a picture, in pixels. Letters come from outlines that come with a crate: a machine without fonts draws the same.

use ab_glyph::{Font, FontRef, Point, ScaleFont, point};

use crate::image::Image;

/// How words are written.
#[derive(Clone, Copy, Debug)]
pub struct Ink {
    /// Height of a line \[pixels\].
    pub size: f32,
    /// Colour, sRGB.
    pub colour: [u8; 3],
}

/// Samples along each side of a pixel of a sign.
const SAMPLES: u32 = 4;

/// The font.
fn font() -> Option<FontRef<'static>> {
    FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).ok()
}

/// Writes `text` from the left end of its baseline \[pixels\]; where it ended.
pub fn write(image: &mut Image, text: &str, (x, y): (f32, f32), ink: Ink) -> f32 {
    let Some(font) = font() else { return x };
    let mut pen = point(x, y);
    for c in text.chars() {
        let id = font.glyph_id(c);
        let glyph = id.with_scale_and_position(ink.size, pen);
        if let Some(outline) = font.outline_glyph(glyph) {
            let corner = outline.px_bounds().min;
            // a light face: covered a little more than it says, to be read on any ground
            outline.draw(|i, j, cover| blend(image, corner, (i, j), ink.colour, (1.25 * cover).min(1.0)));
        }
        pen.x += font.as_scaled(ink.size).h_advance(id);
    }
    pen.x
}

/// Width of `text` in letters of the given size \[pixels\].
pub fn width(text: &str, size: f32) -> f32 {
    font().map_or(0.0, |font| text.chars().map(|c| font.as_scaled(size).h_advance(font.glyph_id(c))).sum())
}

/// A rectangle \[pixels\] that covers so much, 0 to 1, of what is behind.
pub fn fill(image: &mut Image, corner: (f32, f32), size: (f32, f32), colour: [u8; 3], cover: f32) {
    for j in 0..size.1 as u32 {
        for i in 0..size.0 as u32 {
            blend(image, point(corner.0, corner.1), (i, j), colour, cover);
        }
    }
}

/// A sign about `centre`: the points of the square from -1 to 1 (x right, y up), `half` a side \[pixels\], that are `inside`.
pub fn shape(image: &mut Image, centre: (f32, f32), half: f32, colour: [u8; 3], inside: impl Fn(f32, f32) -> bool) {
    let corner = point((centre.0 - half).floor(), (centre.1 - half).floor());
    let side = (2.0 * half).ceil() as u32 + 1;
    for (i, j) in (0..side * side).map(|k| (k % side, k / side)) {
        let hits = (0..SAMPLES * SAMPLES).filter(|k| {
            let part = |k: u32| (k as f32 + 0.5) / SAMPLES as f32;
            let x = corner.x + i as f32 + part(k % SAMPLES) - centre.0;
            let y = corner.y + j as f32 + part(k / SAMPLES) - centre.1;
            x.abs() < half && y.abs() < half && inside(x / half, -y / half)
        });
        blend(image, corner, (i, j), colour, hits.count() as f32 / (SAMPLES * SAMPLES) as f32);
    }
}

/// A straight line \[pixels\], `half` its width.
pub fn stroke(image: &mut Image, from: (f32, f32), to: (f32, f32), half: f32, colour: [u8; 3]) {
    let (x, y) = (to.0 - from.0, to.1 - from.1);
    let length = x.hypot(y).max(1.0e-3);
    let reach = length / 2.0 + half;
    let middle = ((from.0 + to.0) / 2.0, (from.1 + to.1) / 2.0);
    shape(image, middle, reach, colour, |a, b| {
        let (a, b) = (a * reach, -b * reach);
        let (along, across) = ((a * x + b * y) / length, (a * y - b * x) / length);
        along.abs() < length / 2.0 && across.abs() < half
    });
}

fn blend(image: &mut Image, corner: Point, (i, j): (u32, u32), colour: [u8; 3], cover: f32) {
    let (x, y) = (corner.x as i64 + i64::from(i), corner.y as i64 + i64::from(j));
    if x < 0 || y < 0 || x >= i64::from(image.width) || y >= i64::from(image.height) {
        return;
    }
    let at = 3 * (y as usize * image.width as usize + x as usize);
    for (old, new) in image.rgb[at..at + 3].iter_mut().zip(colour) {
        *old = (f32::from(*old) * (1.0 - cover) + f32::from(new) * cover).round() as u8;
    }
}
