//! The histogram of tick times as a picture: one row a level, times along on a logarithmic axis, counts up on another, quantiles marked.

use std::path::Path;

use anyhow::{Context, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::measure::Timed;
use super::report::Report;
use crate::plot::{self, FONT};

/// Width of the picture and height of a row \[pixels\].
const WIDTH: u32 = 1200;
const ROW: u32 = 200;

/// Height of the title, and of the time axis below the last row \[pixels\].
const TITLE: u32 = 60;
const AXIS: u32 = 40;

/// Columns to a decade of time: finer than anybody sees apart, coarser than the measured bins of 1 %.
const PER_DECADE: f64 = 60.0;

/// Marked quantiles: name, colour.
const MARKS: [(&str, RGBColor); 4] = [
    ("p50", RGBColor(0, 158, 115)),
    ("p99.9", RGBColor(230, 159, 0)),
    ("p99.99", RGBColor(213, 94, 0)),
    ("max", RGBColor(0, 0, 0)),
];

/// Room that the name of a mark takes \[pixels\].
const NAME_WIDTH: i32 = 95;

/// Fill of the columns.
const FILL: RGBColor = RGBColor(0, 114, 178);

/// Grey of lines that help the eye.
const GRID: RGBColor = RGBColor(225, 225, 225);

/// Draws the histograms of every level that was timed.
///
/// # Errors
/// When the picture cannot be drawn or written.
pub fn draw(path: &Path, report: &Report) -> anyhow::Result<()> {
    plot::fonts()?;
    paint(path, report).map_err(|error| anyhow!("{error}")).with_context(|| format!("{}", path.display()))
}

type Drawn = Result<(), Box<dyn std::error::Error>>;

fn paint(path: &Path, report: &Report) -> Drawn {
    let rows: Vec<(String, &Timed)> =
        report.levels.iter().filter_map(|found| Some((found.level.name(), found.timed.as_ref()?))).collect();
    let area = BitMapBackend::new(path, (WIDTH, TITLE + ROW * rows.len() as u32 + AXIS)).into_drawing_area();
    area.fill(&WHITE)?;
    let ticks = rows.first().map_or(0, |(_, timed)| timed.ticks);
    let title = format!("{}: time of a tick, dearest input, {ticks} ticks a tier", report.scene);
    area.draw(&Text::new(title, (20, 18), (FONT, 28).into_font()))?;
    let low = rows.iter().filter_map(|(_, timed)| timed.bins.first()).map(|bin| bin.0).min().unwrap_or(1).max(1) as f64;
    let high = rows.iter().map(|(_, timed)| timed.max).max().unwrap_or(1) as f64;
    // to the right room for the names of the tiers
    let times = 0.8 * low / 1000.0..6.0 * high / 1000.0;
    for (index, (name, timed)) in rows.iter().enumerate() {
        let (top, last) = (TITLE + ROW * index as u32, index + 1 == rows.len());
        let bottom = top + ROW + if last { AXIS } else { 0 };
        let part = area.clone().shrink((0, top), (WIDTH, bottom - top));
        row(&part, name, timed, &times, last)?;
    }
    area.present()?;
    Ok(())
}

fn row(
    area: &DrawingArea<BitMapBackend<'_>, Shift>,
    name: &str,
    timed: &Timed,
    times: &std::ops::Range<f64>,
    last: bool,
) -> Drawn {
    let columns = columns(timed);
    let most = columns.iter().map(|column| column.2).max().unwrap_or(1) as f64;
    // room above the highest column for the names of the marks
    let counts = 0.5..(most * 20.0).max(100.0);
    let mut chart = ChartBuilder::on(area)
        .margin_left(10)
        .margin_right(24)
        .margin_top(4)
        .y_label_area_size(90)
        .x_label_area_size(if last { AXIS + 14 } else { 14 })
        .build_cartesian_2d(times.clone().log_scale(), counts.clone().log_scale())?;
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(WHITE)
        .bold_line_style(GRID)
        .label_style((FONT, 16))
        .axis_desc_style((FONT, 18))
        .y_labels(4)
        .y_desc("ticks");
    let (time, count) = (|time: &f64| if last { format!("{time}") } else { String::new() }, |count: &f64| power(*count));
    mesh.x_label_formatter(&time).y_label_formatter(&count);
    if last {
        mesh.x_desc("time of a tick [us]");
    }
    mesh.draw()?;
    chart
        .draw_series(columns.iter().map(|&(from, to, count)| Rectangle::new([(from, 0.5), (to, count as f64)], FILL.filled())))?;
    let values = [timed.p50, timed.p999, timed.p9999, timed.max].map(|ns| ns as f64 / 1000.0);
    for ((_, colour), time) in MARKS.iter().zip(values) {
        chart.draw_series(LineSeries::new([(time, counts.start), (time, counts.end)], colour.stroke_width(2)))?;
    }
    let pixels = values.map(|time| chart.plotting_area().map_coordinate(&(time, counts.end)));
    label(area, name, values, pixels)
}

/// Names the row, and the marked quantiles at the upper ends of their lines, one below the other.
fn label(area: &DrawingArea<BitMapBackend<'_>, Shift>, name: &str, values: [f64; 4], pixels: [(i32, i32); 4]) -> Drawn {
    let (left, top) = area.get_base_pixel();
    for (k, ((mark, colour), time)) in MARKS.iter().zip(values).enumerate() {
        // on the left of its line where the next one is too close
        let crowded = pixels.get(k + 1).is_some_and(|next| next.0 - pixels[k].0 < NAME_WIDTH);
        let (at, side) = if crowded { (HPos::Right, -5) } else { (HPos::Left, 5) };
        let style = (FONT, 16).into_font().color(colour).pos(Pos::new(at, VPos::Top));
        area.draw_text(&format!("{mark} {time:.1}"), &style, (pixels[k].0 - left + side, pixels[k].1 - top + 2 + 17 * k as i32))?;
    }
    let style = (FONT, 22).into_font().color(&BLACK).pos(Pos::new(HPos::Right, VPos::Bottom));
    area.draw_text(name, &style, (WIDTH as i32 - 34, ROW as i32 - 26))?;
    Ok(())
}

/// A count as a power of ten where it is one.
fn power(count: f64) -> String {
    if count < 10_000.0 { format!("{count}") } else { format!("10^{}", count.log10().round()) }
}

/// Columns of equal width on the picture: from, to \[us\], count.
fn columns(timed: &Timed) -> Vec<(f64, f64, u64)> {
    let edge = |column: i64| 10.0_f64.powf(column as f64 / PER_DECADE);
    let mut columns: Vec<(i64, u64)> = Vec::new();
    for &(upper, count) in &timed.bins {
        let column = ((upper.max(1) as f64 / 1000.0).log10() * PER_DECADE).floor() as i64;
        match columns.last_mut() {
            Some(last) if last.0 == column => last.1 += count,
            _ => columns.push((column, count)),
        }
    }
    columns.into_iter().map(|(column, count)| (edge(column), edge(column + 1), count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_tick_is_lost_between_bins_and_columns() {
        let bins: Vec<_> = (1..500).map(|k| (97 * k, k)).collect();
        let total: u64 = bins.iter().map(|bin| bin.1).sum();
        let line = r#"{"ticks":1,"clock_ns":1,"preempted":0,"fifo":true,"locked":true,"pinned":true,"p50":1,"p99":1,"p999":1,"p9999":1,"max":1,"bins":[]}"#;
        let timed = Timed { bins, ..serde_json::from_str(line).unwrap() };
        let columns = columns(&timed);
        assert_eq!(columns.iter().map(|column| column.2).sum::<u64>(), total);
        assert!(columns.is_sorted_by(|a, b| a.1 <= b.0 + 1.0e-9), "columns overlap");
    }
}
