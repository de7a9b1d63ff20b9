//! The legend over the picture: as on a picture without a window, in egui's letters.

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};
use glam::DMat3;

use super::style;
use crate::picture::{Bar, Colour, Legend, MAKO, Row, Sign};

/// Words on the light ground of the picture.
pub const INK: Color32 = Color32::from_rgb(32, 36, 44);

/// Scales on it.
const FAINT: Color32 = Color32::from_rgb(84, 90, 102);

/// Under the legend: what is behind does not make it unreadable.
const PLATE: Color32 = Color32::from_rgba_premultiplied(190, 191, 192, 192);

/// Height of a line \[points\].
const LINE: f32 = 20.0;

/// Height of the colour scale \[points\].
const BAR: f32 = 220.0;

/// Room at the edges \[points\].
const MARGIN: f32 = 14.0;

/// Half a sign \[points\].
const SIGN: f32 = 6.5;

/// Writes the legend over the picture in `rect`, seen along `axes` (rows: right, up, towards the viewer).
pub fn show(painter: &Painter, rect: Rect, legend: &Legend, axes: DMat3) {
    let painter = painter.with_clip_rect(rect);
    let plate = painter.add(Shape::Noop);
    let corner = rect.left_top() + vec2(MARGIN, MARGIN);
    let mut right = corner.x;
    for (number, row) in legend.rows.iter().enumerate() {
        right = right.max(show_row(&painter, corner + vec2(0.0, LINE * (number as f32 + 0.5)), row));
    }
    let under = Rect::from_min_max(corner, pos2(right, corner.y + LINE * legend.rows.len() as f32));
    painter.set(plate, Shape::rect_filled(under.expand(6.0), 6.0, PLATE));
    if let Some(bar) = &legend.bar {
        show_bar(&painter, pos2(rect.right() - MARGIN, rect.top() + MARGIN), bar);
    }
    show_axes(&painter, rect.left_bottom() + vec2(40.0, -40.0), axes);
}

/// What could not be drawn.
pub fn show_trouble(painter: &Painter, rect: Rect, refused: u32, failure: Option<&str>) {
    let refused = (refused > 0).then(|| format!("{refused} values were not finite or did not fit: drawn as nothing"));
    let failure = failure.map(|words| format!("the graphics driver does not draw: {words}"));
    for (number, words) in refused.iter().chain(&failure).enumerate() {
        let at = rect.center_bottom() - vec2(0.0, MARGIN + LINE * number as f32);
        painter.text(at, Align2::CENTER_BOTTOM, words, FontId::proportional(13.5), style::BAD);
    }
}

fn colour([r, g, b, _]: Colour) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// Writes a row; where it ends.
fn show_row(painter: &Painter, left: Pos2, row: &Row) -> f32 {
    show_sign(painter, left + vec2(SIGN, 0.0), row.sign, colour(row.colour));
    let from = left + vec2(3.6 * SIGN, 0.0);
    let words = painter.text(from, Align2::LEFT_CENTER, &row.words, FontId::proportional(14.0), INK);
    let at = pos2(words.right() + 10.0, left.y);
    painter.text(at, Align2::LEFT_CENTER, &row.scale, FontId::proportional(12.0), FAINT).right()
}

fn show_sign(painter: &Painter, at: Pos2, sign: Sign, colour: Color32) {
    match sign {
        Sign::Arrow => {
            let neck = at + vec2(0.2 * SIGN, 0.0);
            painter.line_segment([at - vec2(SIGN, 0.0), neck], Stroke::new(2.6, colour));
            let head = [at + vec2(1.2 * SIGN, 0.0), neck + vec2(0.0, 0.7 * SIGN), neck - vec2(0.0, 0.7 * SIGN)];
            painter.add(Shape::convex_polygon(head.to_vec(), colour, Stroke::NONE));
        }
        Sign::Arc => {
            let out = |degrees: f32| vec2(degrees.to_radians().cos(), -degrees.to_radians().sin());
            let bend = (0..=24).map(|k| at + 0.8 * SIGN * out(-40.0 - 10.5 * k as f32)).collect();
            painter.add(Shape::line(bend, Stroke::new(2.4, colour)));
            let (end, along) = (at + 0.8 * SIGN * out(-292.0), vec2(0.93, 0.37) * SIGN);
            let across = vec2(-along.y, along.x) * 0.7;
            painter.add(Shape::convex_polygon(vec![end + along, end + across, end - across], colour, Stroke::NONE));
        }
        Sign::Disc => {
            painter.circle_filled(at, 0.9 * SIGN, colour);
        }
        Sign::Ring => {
            painter.circle_stroke(at, 0.75 * SIGN, Stroke::new(0.4 * SIGN, colour));
        }
        Sign::Tile => {
            painter.rect_filled(Rect::from_center_size(at, vec2(1.8, 1.8) * SIGN), 0.0, colour);
        }
    }
}

/// The colour scale, upright, its upper right corner at `corner`.
fn show_bar(painter: &Painter, corner: Pos2, bar: &Bar) {
    let plate = painter.add(Shape::Noop);
    let title = painter.text(corner, Align2::RIGHT_TOP, &bar.title, FontId::proportional(13.5), INK);
    let top = title.bottom() + 10.0;
    let scale = Rect::from_min_max(pos2(corner.x - 16.0, top), pos2(corner.x, top + BAR));
    let under = Rect::from_min_max(title.left_top(), scale.right_bottom() + vec2(0.0, 6.0));
    painter.set(plate, Shape::rect_filled(under.expand(6.0), 6.0, PLATE));
    let step = BAR / MAKO.len() as f32;
    for (number, [r, g, b]) in MAKO.iter().enumerate() {
        let low = scale.bottom() - step * number as f32;
        let stripe = Rect::from_min_max(pos2(scale.left(), low - step - 0.5), pos2(scale.right(), low));
        painter.rect_filled(stripe, 0.0, Color32::from_rgb(*r, *g, *b));
    }
    for (share, words) in &bar.ticks {
        let at = pos2(scale.left(), scale.bottom() - *share as f32 * BAR);
        painter.line_segment([at - vec2(5.0, 0.0), at], Stroke::new(1.0, FAINT));
        painter.text(at - vec2(9.0, 0.0), Align2::RIGHT_CENTER, words, FontId::proportional(13.0), INK);
    }
}

/// Three strokes for x, y and z as they are seen.
fn show_axes(painter: &Painter, origin: Pos2, axes: DMat3) {
    for (axis, name) in axes.to_cols_array_2d().iter().zip(["x", "y", "z"]) {
        let reach = vec2(axis[0] as f32, -axis[1] as f32) * 24.0;
        painter.line_segment([origin, origin + reach], Stroke::new(2.0, FAINT));
        painter.text(origin + 1.35 * reach, Align2::CENTER_CENTER, name, FontId::proportional(13.0), INK);
    }
}
