//! The legend on a picture: signs with their meaning in the upper left corner, the colour scale at the right edge, the axes of the world in the
//! lower left corner.

use glam::DMat3;

use crate::image::Image;
use crate::picture::{Bar, Legend, MAKO, Row, Sign};
use crate::text::{self, Ink};

/// Ground under the legend, and how much it covers.
const PLATE: ([u8; 3], f32) = ([250, 251, 253], 0.7);

/// Height of a line of text, per height of the picture.
const LINE: f32 = 1.0 / 30.0;

/// Pictures below this height have no room for words \[pixels\].
const LEAST_HEIGHT: u32 = 240;

/// Dark grey of the words.
const INK: [u8; 3] = [32, 36, 44];

/// Grey of scales and ticks.
const FAINT: [u8; 3] = [88, 94, 106];

/// Writes the legend of a picture seen along `axes` (rows: right, up, towards the viewer).
pub fn draw(image: &mut Image, legend: &Legend, axes: DMat3) {
    if image.height < LEAST_HEIGHT {
        return;
    }
    let line = LINE * image.height as f32;
    draw_plate(image, &legend.rows, line);
    let mut y = 1.5 * line;
    for row in &legend.rows {
        let [r, g, b, _] = row.colour;
        text::shape(image, (1.1 * line, y - 0.32 * line), 0.42 * line, [r, g, b], |x, y| inside(row.sign, x, y));
        let ink = Ink { size: 0.95 * line, colour: INK };
        let end = text::write(image, &row.words, (1.9 * line, y), ink);
        text::write(image, &row.scale, (end + 0.7 * line, y), Ink { size: 0.8 * line, colour: FAINT });
        y += 1.15 * line;
    }
    if let Some(bar) = &legend.bar {
        draw_bar(image, bar, line);
    }
    draw_axes(image, axes, line);
}

/// Light ground under the rows: what is behind does not make them unreadable.
fn draw_plate(image: &mut Image, rows: &[Row], line: f32) {
    let width = |row: &Row| text::width(&row.words, 0.95 * line) + 0.7 * line + text::width(&row.scale, 0.8 * line);
    let widest = rows.iter().map(width).fold(0.0, f32::max);
    let size = (1.9 * line + widest, (1.15 * rows.len() as f32 + 0.4) * line);
    text::fill(image, (0.4 * line, 0.45 * line), size, PLATE.0, PLATE.1);
}

/// Is a point of the square from -1 to 1 (x right, y up) within a sign?
fn inside(sign: Sign, x: f32, y: f32) -> bool {
    let r = x.hypot(y);
    match sign {
        Sign::Arrow => y.abs() < 0.2 && (-1.0..0.2).contains(&x) || (0.1..1.0).contains(&x) && y.abs() < 0.75 * (1.0 - x),
        Sign::Arc => {
            let open = x > 0.0 && y > -0.15;
            (0.55..0.95).contains(&r) && !open
                || (0.25..0.75 + 0.5).contains(&x) && (x - 0.25) < 0.75 * (0.75 - (y - 0.75).abs() * 1.4)
        }
        Sign::Disc => r < 0.9,
        Sign::Ring => (0.5..0.9).contains(&r),
        Sign::Tile => x.abs() < 0.9 && y.abs() < 0.9,
    }
}

/// The colour scale, upright, figures at its left.
fn draw_bar(image: &mut Image, bar: &Bar, line: f32) {
    let (width, height) = (0.8 * line, 11.0 * line);
    let (left, top) = (image.width as f32 - 1.6 * line, 2.6 * line);
    let words = text::width(&bar.title, 0.85 * line) + line;
    text::fill(image, (image.width as f32 - words - 0.3 * line, 0.6 * line), (words, height + 2.6 * line), PLATE.0, PLATE.1);
    for step in 0..height as u32 {
        let share = 1.0 - (step as f32 + 0.5) / height.floor();
        let colour = MAKO[usize::from((255.0 * share) as u8)];
        text::fill(image, (left, top + step as f32), (width, 1.0), colour, 1.0);
    }
    let ink = Ink { size: 0.85 * line, colour: INK };
    for (share, words) in &bar.ticks {
        let y = top + (1.0 - *share as f32) * (height.floor() - 1.0);
        text::fill(image, (left - 0.3 * line, y), (0.3 * line, 1.0), FAINT, 1.0);
        text::write(image, words, (left - 0.5 * line - text::width(words, ink.size), y + 0.28 * line), ink);
    }
    let right = left + width - text::width(&bar.title, ink.size);
    text::write(image, &bar.title, (right, top - 0.8 * line), ink);
}

/// Three arrows for x, y and z as they are seen.
fn draw_axes(image: &mut Image, axes: DMat3, line: f32) {
    let (origin, reach) = ((2.2 * line, image.height as f32 - 2.2 * line), 1.3 * line);
    for (axis, name) in axes.to_cols_array_2d().iter().zip(["x", "y", "z"]) {
        let (x, y) = (axis[0] as f32 * reach, -axis[1] as f32 * reach);
        text::stroke(image, origin, (origin.0 + x, origin.1 + y), 0.09 * line, FAINT);
        let size = 0.75 * line;
        let at = (origin.0 + 1.3 * x - 0.25 * size, origin.1 + 1.3 * y + 0.25 * size);
        text::write(image, name, at, Ink { size, colour: INK });
    }
}
