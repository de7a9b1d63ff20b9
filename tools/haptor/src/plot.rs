//! Line plots as PNG: time along, a quantity with its unit up, one colour per curve and a legend.
//!
//! Colours are Okabe and Ito's, told apart with any colour vision (jfly.uni-koeln.de/color, 2008). The font comes with a crate,
//! so a machine without fonts draws the same picture.

use std::cmp::Ordering;
use std::path::Path;
use std::sync::OnceLock;

use anyhow::{Context, anyhow};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// One curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: &'static str,
    /// Points (t \[s\], value).
    pub points: Vec<(f64, f64)>,
}

/// Size of a picture \[pixels\].
const SIZE: (u32, u32) = (1200, 640);

/// Height of a panel among others \[pixels\].
const PANEL_HEIGHT: u32 = 400;

/// Most points drawn of a curve: some twenty per column of pixels; more would draw the same picture.
const MAX_POINTS: usize = 20_000;

/// Grey for the magnitude, drawn first and wide; then blue, vermilion, green.
const COLOURS: [RGBColor; 4] = [RGBColor(190, 190, 190), RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// Width of each curve \[pixels\].
const WIDTHS: [u32; 4] = [4, 2, 2, 2];

/// What goes along unless something else is said.
const TIME: &str = "time [s]";

/// The name under which the font is registered.
pub const FONT: &str = "sans-serif";

/// Registers the font once.
///
/// # Errors
/// When the font that comes with a crate cannot be read.
pub fn fonts() -> anyhow::Result<()> {
    static DONE: OnceLock<bool> = OnceLock::new();
    let done = DONE.get_or_init(|| register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok());
    if *done { Ok(()) } else { Err(anyhow!("the font of the plots cannot be read")) }
}

/// Draws curves over time into a PNG file.
///
/// # Errors
/// When the picture cannot be drawn or written.
pub fn draw(path: &Path, title: &str, unit_label: &str, curves: &[Curve]) -> anyhow::Result<()> {
    fonts()?;
    paint(path, title, unit_label, curves).map_err(|error| anyhow!("{error}")).with_context(|| format!("{}", path.display()))
}

/// A quantity in a panel of its own: its label with the unit, its curves.
pub type Panel = (&'static str, Vec<Curve>);

/// Draws panels under each other, each over the same time, into a PNG file.
///
/// # Errors
/// When the picture cannot be drawn or written.
pub fn draw_panels(path: &Path, title: &str, panels: &[Panel]) -> anyhow::Result<()> {
    draw_panels_over(TIME, path, title, panels)
}

/// The same over another quantity, its label with the unit.
///
/// # Errors
/// When the picture cannot be drawn or written.
pub fn draw_panels_over(along: &str, path: &Path, title: &str, panels: &[Panel]) -> anyhow::Result<()> {
    fonts()?;
    paint_panels(path, title, along, panels).map_err(|error| anyhow!("{error}")).with_context(|| format!("{}", path.display()))
}

fn paint_panels(path: &Path, title: &str, along: &str, panels: &[Panel]) -> Result<(), Box<dyn std::error::Error>> {
    let area = BitMapBackend::new(path, (SIZE.0, PANEL_HEIGHT * panels.len() as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (index, (part, (label, curves))) in area.split_evenly((panels.len(), 1)).iter().zip(panels).enumerate() {
        chart(part, if index == 0 { title } else { "" }, along, label, curves)?;
    }
    area.present()?;
    Ok(())
}

fn paint(path: &Path, title: &str, label: &str, curves: &[Curve]) -> Result<(), Box<dyn std::error::Error>> {
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    chart(&area, title, TIME, label, curves)?;
    area.present()?;
    Ok(())
}

/// Where a chart is drawn.
type Area<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;

fn chart(area: &Area<'_>, title: &str, along: &str, label: &str, curves: &[Curve]) -> Result<(), Box<dyn std::error::Error>> {
    let (time, value) = ranges(curves);
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 28))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(80)
        .build_cartesian_2d(time, value)?;
    chart
        .configure_mesh()
        .x_desc(along)
        .y_desc(label)
        .max_light_lines(0)
        .label_style((FONT, 18))
        .axis_desc_style((FONT, 22))
        .draw()?;
    let looks = COLOURS.iter().zip(WIDTHS).cycle();
    for (curve, (colour, width)) in curves.iter().zip(looks) {
        let style = colour.stroke_width(width);
        let series = chart.draw_series(LineSeries::new(thinned(&curve.points), style))?;
        series.label(curve.name).legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
    }
    let mut legend = chart.configure_series_labels();
    legend.position(SeriesLabelPosition::UpperRight).label_font((FONT, 20)).legend_area_size(36);
    legend.background_style(WHITE.mix(0.85)).border_style(RGBColor(160, 160, 160)).draw()?;
    Ok(())
}

/// Ranges of time and value, with room above and below; never empty.
fn ranges(curves: &[Curve]) -> (std::ops::Range<f64>, std::ops::Range<f64>) {
    let all = || curves.iter().flat_map(|curve| curve.points.iter());
    let span = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) =
            all().map(of).filter(|v| v.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        match low.total_cmp(&high) {
            Ordering::Less => (low, high),
            Ordering::Equal => (low - 1.0, high + 1.0),
            // no point at all
            Ordering::Greater => (0.0, 1.0),
        }
    };
    let ((start, end), (low, high)) = (span(|p| p.0), span(|p| p.1));
    let room = 0.05 * (high - low);
    // a session's time begins a moment after zero
    let start = if (0.0..0.1 * end).contains(&start) { 0.0 } else { start };
    (start..end, low - room..high + room)
}

/// At most [`MAX_POINTS`] points that draw the same line: the lowest and the highest of each stretch.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= MAX_POINTS {
        return points.to_vec();
    }
    let stretch = (2 * points.len()).div_ceil(MAX_POINTS);
    let ends = |part: &[(f64, f64)]| {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (low, high) = (part.iter().min_by(by_value), part.iter().max_by(by_value));
        let mut ends: Vec<_> = low.into_iter().chain(high).copied().collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends
    };
    points.chunks(stretch).flat_map(ends).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_peaks() {
        let mut points: Vec<_> = (0..1_000_000).map(|k| (f64::from(k), 0.0)).collect();
        points[123_457].1 = 7.0;
        points[765_431].1 = -3.0;
        let thin = thinned(&points);
        assert!(thin.len() <= MAX_POINTS);
        assert!(thin.contains(&(123_457.0, 7.0)) && thin.contains(&(765_431.0, -3.0)));
    }

    #[test]
    fn nothing_and_a_flat_line_still_have_a_range() {
        for points in [vec![], vec![(0.0, 0.0), (1.0, 0.0)], vec![(0.0, 5.0)]] {
            let (time, value) = ranges(&[Curve { name: "f", points }]);
            assert!(time.start < time.end && value.start < value.end, "{time:?} {value:?}");
            assert!(time.end.is_finite() && value.end.is_finite());
        }
    }
}
