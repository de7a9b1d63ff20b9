//! What the colours of a picture mean, with figures and units, in its upper left corner, where the sky is.

use crate::image::Image;
use crate::raster::{Colour, encoded};
use crate::shot::{FORCE, SLIPPING, STUCK, Shot, Surface, TORQUE, moved_colour};
use crate::text;

/// Height of a line of text, per height of the picture.
const LINE: f32 = 1.0 / 28.0;

/// Pictures below this height have no room for words \[pixels\].
const LEAST_HEIGHT: u32 = 240;

/// Dark grey of the words.
const INK: [u8; 3] = [40, 44, 52];

/// Steps of the colour scale.
const STEPS: u32 = 64;

/// Writes the legend.
pub fn draw(image: &mut Image, shot: &Shot<'_>) {
    if image.height < LEAST_HEIGHT {
        return;
    }
    let line = LINE * image.height as f32;
    let mut rows = vec![
        (encoded(FORCE), format!("force {} N", figure(shot.force.length()))),
        (encoded(TORQUE), format!("torque {} mN m", figure(1.0e3 * shot.torque.length()))),
    ];
    if !shot.regions.is_empty() {
        rows.push((encoded(STUCK), "sticks".to_owned()));
        rows.push((encoded(SLIPPING), "slips".to_owned()));
    }
    let most = shot.surface.as_ref().map_or(0.0, Surface::most);
    let mut y = 1.4 * line;
    for (colour, words) in &rows {
        text::fill(image, (line * 0.6, y - 0.62 * line), (0.7 * line, 0.7 * line), *colour, 1.0);
        text::write(image, words, 1.7 * line, y, 0.95 * line, INK);
        y += line;
    }
    if most > 0.0 {
        draw_scale(image, y, line, most);
    }
}

/// The colours of the surface's displacement, from none to the largest \[m\].
fn draw_scale(image: &mut Image, y: f32, line: f32, most: f64) {
    let (start, step) = (0.6 * line, (0.1 * line).max(1.0).floor());
    for k in 0..STEPS {
        let colour: Colour = moved_colour(f64::from(k) / f64::from(STEPS - 1));
        text::fill(image, (start + step * k as f32, y - 0.62 * line), (step, 0.7 * line), encoded(colour), 1.0);
    }
    let words = format!("moved 0 to {} mm", figure(1.0e3 * most));
    text::write(image, &words, start + step * STEPS as f32 + 0.4 * line, y, 0.95 * line, INK);
}

/// Three figures, as many as an arrow can be read to.
fn figure(value: f64) -> String {
    let decimals = match value {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 1.0 => 2,
        _ => 3,
    };
    format!("{value:.decimals$}")
}
