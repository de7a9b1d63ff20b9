//! The map as a picture: a panel for each axis, its values down in their order, the tiers across.
//!
//! Colours from dark (no digit lost) to light (two per cent lost) keep their order in print and for any colour vision; orange is wrong without a word, grey is refused, a dot is a tick that warns of itself.

use std::path::Path;
use std::sync::OnceLock;

use haptor_contact::Tier;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::axes::{AXES, Axis, Found, HOLDS};
use super::words::number;

type Canvas<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A cell, and a panel's room for its labels \[pixels\].
const CELL: (i32, i32) = (30, 21);
const LABELS: i32 = 70;
const GAP: i32 = 26;
const HEAD: i32 = 74;

/// Panels side by side, and values of the longest.
const ACROSS: i32 = 5;
const LONGEST: i32 = 16;

/// Room above and below all panels \[pixels\].
const TOP: i32 = 54;
const BELOW: i32 = 118;

const WRONG: RGBColor = RGBColor(230, 97, 0);
const REFUSED: RGBColor = RGBColor(190, 190, 190);
const LIGHT: (f64, f64, f64) = (222.0, 235.0, 247.0);
const DARK: (f64, f64, f64) = (8.0, 69.0, 148.0);

/// Error that counts as no digit lost: the last two of an f32.
const EXACT: f64 = 1.0e-6;

/// The name under which the font is registered; it comes with a crate, so that every machine draws the same picture.
const FONT: &str = "sans-serif";

/// Draws the map: what was found at every value of every axis.
///
/// # Errors
/// When the font cannot be read or the file not be written.
pub fn draw(path: &Path, map: &[Vec<[Found; 5]>]) -> Drawn {
    static FONTS: OnceLock<bool> = OnceLock::new();
    if !FONTS.get_or_init(|| register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok()) {
        return Err("the font of the plots cannot be read".into());
    }
    let panel = (LABELS + CELL.0 * Tier::ALL.len() as i32 + GAP, HEAD + CELL.1 * LONGEST + GAP);
    let rows = (AXES.len() as i32 + ACROSS - 1) / ACROSS;
    let size = (ACROSS * panel.0 + GAP, TOP + rows * panel.1 + BELOW);
    let area = BitMapBackend::new(path, (size.0 as u32, size.1 as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    label(&area, "What an f32 loses at the ends of the ranges, and beyond", (GAP, 26), 26, HPos::Left)?;
    for (i, (axis, found)) in AXES.iter().zip(map).enumerate() {
        let (column, row) = (i as i32 % ACROSS, i as i32 / ACROSS);
        draw_panel(&area, axis, found, (GAP / 2 + column * panel.0, TOP + row * panel.1))?;
    }
    footer(&area, size.1)?;
    area.present()?;
    Ok(())
}

fn draw_panel(area: &Canvas<'_>, axis: &Axis, found: &[[Found; 5]], (x, y): (i32, i32)) -> Drawn {
    label(area, &format!("{} [{}]", axis.name, axis.unit), (x + 8, y + 12), 19, HPos::Left)?;
    label(area, &format!("against {}", axis.against), (x + 8, y + 32), 14, HPos::Left)?;
    for (column, tier) in Tier::ALL.iter().enumerate() {
        let name: String = tier.name().chars().take(5).collect();
        let at = (x + LABELS + column as i32 * CELL.0 + CELL.0 / 2, y + HEAD - 12);
        label(area, &name, at, 12, HPos::Center)?;
    }
    for (row, (value, cells)) in axis.values.iter().zip(found).enumerate() {
        let top = y + HEAD + row as i32 * CELL.1;
        let inside = (axis.asked.0..=axis.asked.1).contains(value);
        // what is asked for is marked by a bar
        if inside {
            area.draw(&Rectangle::new([(x + LABELS - 5, top), (x + LABELS - 3, top + CELL.1 - 1)], BLACK.filled()))?;
        }
        label(area, &number(*value), (x + LABELS - 10, top + CELL.1 / 2), 14, HPos::Right)?;
        for (column, cell) in cells.iter().enumerate() {
            draw_cell(area, *cell, (x + LABELS + column as i32 * CELL.0, top))?;
        }
    }
    Ok(())
}

fn draw_cell(area: &Canvas<'_>, found: Found, (left, top): (i32, i32)) -> Drawn {
    let corners = [(left, top), (left + CELL.0 - 2, top + CELL.1 - 2)];
    let middle = (left + CELL.0 / 2 - 1, top + CELL.1 / 2 - 1);
    match found {
        Found::Nothing => return Ok(()),
        Found::Untold => {
            area.draw(&Rectangle::new(corners, REFUSED.stroke_width(1)))?;
            label(area, "-", middle, 14, HPos::Center)?;
        }
        Found::Refused => area.draw(&Rectangle::new(corners, REFUSED.filled()))?,
        Found::Held(off) | Found::Warned(off) => {
            let (fill, dark) = colour(off);
            area.draw(&Rectangle::new(corners, fill.filled()))?;
            if matches!(found, Found::Warned(_)) {
                area.draw(&Circle::new(middle, 4, if dark { WHITE.filled() } else { BLACK.filled() }))?;
            }
        }
    }
    Ok(())
}

/// Colour of an error, and whether it is a dark one.
fn colour(off: f64) -> (RGBColor, bool) {
    if off > HOLDS {
        return (WRONG, false);
    }
    let lost = (off.max(EXACT) / EXACT).ln() / (HOLDS / EXACT).ln();
    let mix = |light: f64, dark: f64| (dark + (light - dark) * lost) as u8;
    (RGBColor(mix(LIGHT.0, DARK.0), mix(LIGHT.1, DARK.1), mix(LIGHT.2, DARK.2)), lost < 0.5)
}

fn footer(area: &Canvas<'_>, height: i32) -> Drawn {
    let lines = [
        "Largest error of force and torque over a session, in the contact's own units, against the same session at the value named: dark 1e-6 or less, light up to 2 %, orange more.",
        "A dot: the ticks warn of themselves (flag). Grey: refused by name, at construction or by the tick.",
        "A dash: the pose's digits tell of no contact. White: the axis has no meaning for the tier. The bar beside the values is the range asked for.",
        "Tiers: point, paper, bristle (64 samples), influence (52 cells), green (a cube with its table).",
    ];
    for (i, line) in lines.iter().enumerate() {
        label(area, line, (GAP, height - BELOW + 18 + 26 * i as i32), 16, HPos::Left)?;
    }
    Ok(())
}

fn label(area: &Canvas<'_>, text: &str, at: (i32, i32), size: i32, side: HPos) -> Drawn {
    let style = (FONT, size).into_font().color(&BLACK).pos(Pos::new(side, VPos::Center));
    area.draw(&Text::new(text.to_owned(), at, style))?;
    Ok(())
}
