//! The trade as a picture: error against the dearest tick's time, both axes in powers of ten, a colour for each tier, the frontier as a line.

use std::path::Path;

use anyhow::{Context, anyhow};
use haptor_contact::Tier;
use plotters::prelude::*;

use super::advice;
use super::point::{Point, Trade};
use crate::plot::{FONT, fonts};

/// Size of the picture \[pixels\].
const SIZE: (u32, u32) = (1200, 800);

/// Grey of the frontier, and of the line of the period.
const FRONTIER: RGBColor = RGBColor(120, 120, 120);

/// Okabe and Ito's, told apart with any colour vision.
fn colour(tier: Tier) -> RGBColor {
    match tier {
        Tier::Point => RGBColor(0, 0, 0),
        Tier::Paper => RGBColor(204, 121, 167),
        Tier::Bristle => RGBColor(0, 114, 178),
        Tier::Influence => RGBColor(213, 94, 0),
        Tier::Green => RGBColor(0, 158, 115),
    }
}

/// Draws the points at the rate that was asked for.
///
/// # Errors
/// When no cost was taken, or the picture cannot be drawn or written.
pub fn draw(path: &Path, trade: &Trade) -> anyhow::Result<()> {
    fonts()?;
    paint(path, trade).map_err(|error| anyhow!("{error}")).with_context(|| format!("{}", path.display()))
}

/// Time \[us\] and error \[%\] of a point.
fn place(point: &Point) -> Option<(f64, f64)> {
    point.cost.map(|cost| (cost.worst, 100.0 * point.errors.worst()))
}

fn paint(path: &Path, trade: &Trade) -> Result<(), Box<dyn std::error::Error>> {
    let places: Vec<(f64, f64)> = trade.asked().filter_map(place).collect();
    let span = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) = places.iter().map(of).fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        (low, high)
    };
    let ((fast, slow), (good, bad)) = (span(|p| p.0), span(|p| p.1));
    if places.is_empty() {
        return Err("no costs were taken, so there is nothing to draw; leave out --no-cost".into());
    }
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(format!("{}: error against time, {}", trade.scene, advice::rate(trade.rate)), (FONT, 28))
        .margin(20)
        .x_label_area_size(56)
        .y_label_area_size(80)
        .build_cartesian_2d((0.7 * fast..2.2 * slow).log_scale(), (0.75 * good..1.35 * bad.min(200.0)).log_scale())?;
    let plain = |v: &f64| if *v >= 1.0 { format!("{v:.0}") } else { format!("{v:.1}") };
    chart
        .configure_mesh()
        .x_desc("dearest tick [us]")
        .y_desc("worst error of force and torque [%]")
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .light_line_style(RGBColor(240, 240, 240))
        .bold_line_style(RGBColor(215, 215, 215))
        .label_style((FONT, 18))
        .axis_desc_style((FONT, 22))
        .draw()?;
    let mut frontier: Vec<(f64, f64)> = trade.asked().filter(|point| trade.on_frontier(point)).filter_map(place).collect();
    frontier.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart
        .draw_series(LineSeries::new(frontier, FRONTIER.stroke_width(2)))?
        .label("nothing cheaper is better")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 20, y)], FRONTIER.stroke_width(2)));
    for tier in Tier::ALL {
        let of_tier: Vec<&Point> = trade.asked().filter(|point| point.setting.tier == tier).collect();
        if of_tier.is_empty() {
            continue;
        }
        let dots = of_tier.iter().filter_map(|point| Some((place(point)?, trade.on_frontier(point))));
        let dot = |((x, y), best): ((f64, f64), bool)| {
            Circle::new((x, y), if best { 7 } else { 5 }, if best { colour(tier).filled() } else { colour(tier).stroke_width(2) })
        };
        chart
            .draw_series(dots.map(dot))?
            .label(tier.name())
            .legend(move |(x, y)| Circle::new((x + 10, y), 6, colour(tier).filled()));
    }
    let mut taken: Vec<(i32, i32, i32)> = Vec::new();
    for point in trade.asked() {
        let Some(at) = place(point) else { continue };
        let (x, y) = chart.backend_coord(&at);
        let name = match point.setting.name().split_once(' ') {
            Some((_, numbers)) => numbers.to_owned(),
            None => point.setting.name(),
        };
        let place = free(&mut taken, (x, y), 9 * name.len() as i32);
        area.draw(&Text::new(name, place, (FONT, 17).into_font().color(&colour(point.setting.tier))))?;
    }
    let mut legend = chart.configure_series_labels();
    legend.position(SeriesLabelPosition::UpperRight).label_font((FONT, 19)).legend_area_size(28);
    legend.background_style(WHITE.mix(0.9)).border_style(RGBColor(160, 160, 160)).draw()?;
    area.present()?;
    Ok(())
}

/// A place beside a dot for a label of that width which no other label has: right above, right below, and further down in lines.
fn free(taken: &mut Vec<(i32, i32, i32)>, (x, y): (i32, i32), width: i32) -> (i32, i32) {
    const LINE: i32 = 17;
    let places = [(9, -20), (9, 4), (-9 - width, -20), (-9 - width, 4)].into_iter().chain((1..12).map(|i| (9, 4 + i * LINE)));
    let clear =
        |&(left, top): &(i32, i32)| taken.iter().all(|&(l, t, w)| left + width < l || l + w < left || (top - t).abs() >= LINE);
    let found = places.map(|(dx, dy)| (x + dx, y + dy)).find(clear).unwrap_or((x + 9, y - 20));
    taken.push((found.0, found.1, width));
    found
}
