//! The map as a picture: a row of panels for each device, four panels for each hand.
//!
//! Colours from dark (stands every delay of the map) to red (shakes without any) keep their order in print and for any colour vision.

use std::path::Path;
use std::sync::OnceLock;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::map::{HANDS, MACHINES, MODULI, Map, Panel, RATES, Stands, VARIANTS};

type Canvas<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Size of a cell, gap between panels, between hands \[pixels\].
const CELL: (i32, i32) = (29, 24);
const GAP: (i32, i32) = (16, 34);
const BETWEEN_HANDS: i32 = 30;

/// Room on the left and above \[pixels\].
const LEFT: i32 = 176;
const TOP: i32 = 118;
const BELOW: i32 = 96;

/// Red for none, then light to dark blue.
const NONE: RGBColor = RGBColor(213, 94, 0);
const LIGHT: (f64, f64, f64) = (222.0, 235.0, 247.0);
const DARK: (f64, f64, f64) = (8.0, 69.0, 148.0);

/// The name under which the font is registered; it comes with a crate, so that every machine draws the same picture.
const FONT: &str = "sans-serif";

/// Draws the map.
///
/// # Errors
/// When the font cannot be read or the file not be written.
pub fn draw(path: &Path, map: &Map) -> Drawn {
    static FONTS: OnceLock<bool> = OnceLock::new();
    if !FONTS.get_or_init(|| register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok()) {
        return Err("the font of the plots cannot be read".into());
    }
    let panel = (CELL.0 * MODULI.len() as i32 + GAP.0, CELL.1 * RATES.len() as i32 + GAP.1);
    let columns = (HANDS.len() * VARIANTS.len()) as i32;
    let size = (LEFT + columns * panel.0 + BETWEEN_HANDS, TOP + MACHINES.len() as i32 * panel.1 + BELOW);
    let area = BitMapBackend::new(path, (size.0 as u32, size.1 as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    heading(&area)?;
    for (row, (machine, hands)) in MACHINES.iter().zip(map).enumerate() {
        let y = TOP + row as i32 * panel.1;
        label(&area, machine.preset.name, (12, y + panel.1 / 2 - GAP.1), 20, HPos::Left)?;
        for (column, one) in hands.as_flattened().iter().enumerate() {
            let x = LEFT + column as i32 * panel.0 + (column / VARIANTS.len()) as i32 * BETWEEN_HANDS;
            draw_panel(&area, one, (x, y), column == 0)?;
            if row == 0 {
                label(&area, VARIANTS[column % VARIANTS.len()].name, (x, TOP - 14), 18, HPos::Left)?;
            }
        }
    }
    footer(&area, size.1)?;
    area.present()?;
    Ok(())
}

fn heading(area: &Canvas<'_>) -> Drawn {
    label(area, "Ticks of delay that a closed loop stands", (12, 24), 26, HPos::Left)?;
    let width = (CELL.0 * MODULI.len() as i32 + GAP.0) * VARIANTS.len() as i32;
    for (i, (name, hand)) in HANDS.iter().enumerate() {
        let x = LEFT + i as i32 * (width + BETWEEN_HANDS);
        let text = format!("{name} grip: {} kg, {} N s/m", hand.mass, hand.damping);
        label(area, &text, (x, TOP - 46), 22, HPos::Left)?;
    }
    Ok(())
}

fn footer(area: &Canvas<'_>, height: i32) -> Drawn {
    let lines = [
        "In each panel: across, Young's modulus of the object, 30 kPa to 100 MPa in half decades (ball of 20 mm radius); down, rate 0.5, 1, 2, 4, 8 kHz.",
        "Number: the longest delay from 0 to 8 ticks up to which the hold is quiet; after a slash, up to which it only toggles within the encoder's steps.",
        "A dash: not even without delay. Red: shakes without any delay. The virtual coupling has the stiffness that the device closes, the probe 1 kg.",
    ];
    for (i, line) in lines.iter().enumerate() {
        label(area, line, (12, height - BELOW + 22 + 26 * i as i32), 18, HPos::Left)?;
    }
    Ok(())
}

fn draw_panel(area: &Canvas<'_>, panel: &Panel, (x, y): (i32, i32), first: bool) -> Drawn {
    for (row, (cells, rate)) in panel.iter().zip(RATES).enumerate() {
        let top = y + row as i32 * CELL.1;
        if first {
            label(area, &format!("{} kHz", f64::from(rate) / 1000.0), (x - 6, top + CELL.1 / 2), 14, HPos::Right)?;
        }
        for (column, stands) in cells.iter().enumerate() {
            let left = x + column as i32 * CELL.0;
            let corners = [(left, top), (left + CELL.0 - 1, top + CELL.1 - 1)];
            area.draw(&Rectangle::new(corners, colour(stands.bounded).filled()))?;
            let ink = if stands.bounded > 5 || stands.bounded == 0 { WHITE } else { BLACK };
            let style = (FONT, 14).into_font().color(&ink).pos(Pos::new(HPos::Center, VPos::Center));
            area.draw(&Text::new(text(*stands), (left + CELL.0 / 2, top + CELL.1 / 2), style))?;
        }
    }
    Ok(())
}

fn label(area: &Canvas<'_>, text: &str, at: (i32, i32), size: i32, side: HPos) -> Drawn {
    let style = (FONT, size).into_font().color(&BLACK).pos(Pos::new(side, VPos::Center));
    area.draw(&Text::new(text.to_owned(), at, style))?;
    Ok(())
}

fn colour(bounded: u8) -> RGBColor {
    let share = (f64::from(bounded) - 1.0) / super::map::LONGEST as f64;
    let mix = |light: f64, dark: f64| (light + (dark - light) * share) as u8;
    if bounded == 0 { NONE } else { RGBColor(mix(LIGHT.0, DARK.0), mix(LIGHT.1, DARK.1), mix(LIGHT.2, DARK.2)) }
}

/// A cell's words: the same in picture and tables.
pub fn text(stands: Stands) -> String {
    let longest = |count: u8| count.checked_sub(1).map_or("-".to_owned(), |delay| delay.to_string());
    let (quiet, bounded) = (longest(stands.quiet), longest(stands.bounded));
    if quiet == bounded { quiet } else { format!("{quiet}/{bounded}") }
}
