//! The trade as a picture: error against the dearest tick's time, both axes in powers of ten, a colour for each tier, the frontier as a line of steps: everything above and to
//! the right of it is dearer or worse than something on it.

use std::path::Path;

use anyhow::{Context, anyhow};
use haptor_contact::Tier;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::advice::{self, Limits};
use super::point::{Point, Trade};
use crate::plot::{FONT, fonts};

/// Size of the picture \[pixels\].
const SIZE: (u32, u32) = (1200, 800);

/// Room for the legend on the right \[pixels\].
const LEGEND: u32 = 230;

/// Margin about everything \[pixels\].
const MARGIN: u32 = 20;

/// Height of a line of the legend \[pixels\].
const LEGEND_LINE: i32 = 32;

/// Radius of a dot on the frontier, off it, and of the ring about the recommended one \[pixels\].
const DOTS: (i32, i32, i32) = (7, 5, 12);

/// Grey of the frontier.
const FRONTIER: RGBColor = RGBColor(120, 120, 120);

/// What goes wrong while painting.
type Wrong = Box<dyn std::error::Error>;

/// The whole picture.
type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// The plot in it: both axes in powers of ten.
type Chart<'a> = ChartContext<'a, BitMapBackend<'a>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

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

/// Draws the points at the rate that was asked for; the one recommended within `limits` has a ring.
///
/// # Errors
/// When no time was taken, or the picture cannot be drawn or written.
pub fn draw(path: &Path, trade: &Trade, limits: &Limits) -> anyhow::Result<()> {
    fonts()?;
    paint(path, trade, limits).map_err(|error| anyhow!("{error}")).with_context(|| format!("{}", path.display()))
}

/// A point of the picture.
struct Dot {
    tier: Tier,
    /// What stands beside it.
    label: String,
    /// Time \[us\] and error \[%\].
    at: (f64, f64),
    best: bool,
    recommended: bool,
}

fn dots(trade: &Trade, limits: &Limits) -> Vec<Dot> {
    let chosen = advice::choose(trade, limits).map(|point| point.setting);
    let dot = |point: &Point| {
        let name = point.setting.name();
        // the colour says the tier
        let label = name.split_once(' ').map_or(name.clone(), |(_, numbers)| numbers.to_owned());
        let at = (point.cost?.times?.worst, 100.0 * point.errors.worst());
        let recommended = chosen == Some(point.setting);
        Some(Dot { tier: point.setting.tier, label, at, best: trade.on_frontier(point), recommended })
    };
    trade.asked().filter_map(dot).collect()
}

fn paint(path: &Path, trade: &Trade, limits: &Limits) -> Result<(), Wrong> {
    let dots = dots(trade, limits);
    if dots.is_empty() {
        return Err("no times were taken, so there is nothing to draw; leave out --no-cost and --no-time".into());
    }
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = axes(&area, trade, &dots)?;
    frontier(&mut chart, &dots)?;
    for dot in &dots {
        mark(&area, chart.backend_coord(&dot.at), dot.tier, dot.best, dot.recommended)?;
    }
    labels(&area, &chart, &dots)?;
    legend(&area, &dots)?;
    area.present()?;
    Ok(())
}

/// Axes with room about the dots.
fn axes<'a>(area: &Area<'a>, trade: &Trade, dots: &[Dot]) -> Result<Chart<'a>, Wrong> {
    let span =
        |of: fn(&Dot) -> f64| dots.iter().map(of).fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    let ((fast, slow), (good, bad)) = (span(|dot| dot.at.0), span(|dot| dot.at.1));
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{}: error against time, {}", trade.scene, advice::rate(trade.rate)), (FONT, 28))
        .margin(MARGIN)
        .margin_right(LEGEND)
        .x_label_area_size(56)
        .y_label_area_size(80)
        .build_cartesian_2d((0.7 * fast..1.6 * slow).log_scale(), (0.75 * good..1.35 * bad).log_scale())?;
    let plain = |v: &f64| if *v >= 1.0 { format!("{v:.0}") } else { format!("{v:.1}") };
    chart
        .configure_mesh()
        .x_desc("dearest tick [us]")
        .y_desc("worst error of force and torque [%]")
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .max_light_lines(0)
        .bold_line_style(RGBColor(225, 225, 225))
        .label_style((FONT, 18))
        .axis_desc_style((FONT, 22))
        .draw()?;
    Ok(chart)
}

/// The frontier as steps: from a dot on it the error stays what it is until a dearer one is better.
fn frontier(chart: &mut Chart<'_>, dots: &[Dot]) -> Result<(), Wrong> {
    let mut best: Vec<(f64, f64)> = dots.iter().filter(|dot| dot.best).map(|dot| dot.at).collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    let corners = best.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    let steps: Vec<(f64, f64)> = corners.chain(best.last().copied()).collect();
    chart.draw_series(LineSeries::new(steps, FRONTIER.stroke_width(2)))?;
    Ok(())
}

/// A dot: full on the frontier, with a ring where it is recommended.
fn mark(area: &Area<'_>, at: (i32, i32), tier: Tier, best: bool, recommended: bool) -> Result<(), Wrong> {
    let (on, off, ring) = DOTS;
    if best {
        area.draw(&Circle::new(at, on, colour(tier).filled()))?;
    } else {
        area.draw(&Circle::new(at, off, WHITE.filled()))?;
        area.draw(&Circle::new(at, off, colour(tier).stroke_width(2)))?;
    }
    if recommended {
        area.draw(&Circle::new(at, ring, BLACK.stroke_width(2)))?;
    }
    Ok(())
}

/// Numbers beside the dots.
fn labels(area: &Area<'_>, chart: &Chart<'_>, dots: &[Dot]) -> Result<(), Wrong> {
    let places: Vec<(i32, i32)> = dots.iter().map(|dot| chart.backend_coord(&dot.at)).collect();
    let mut taken: Vec<Taken> = places.iter().map(|&(x, y)| Taken { left: x - 6, top: y - 8, width: 12 }).collect();
    for (dot, &at) in dots.iter().zip(&places) {
        let place = free(&mut taken, at, 9 * dot.label.len() as i32);
        area.draw(&Text::new(dot.label.clone(), place, (FONT, 17).into_font().color(&colour(dot.tier))))?;
    }
    Ok(())
}

/// What the colours and marks say, right of the plot, where no dot can be.
fn legend(area: &Area<'_>, dots: &[Dot]) -> Result<(), Wrong> {
    let left = (SIZE.0 - LEGEND + MARGIN) as i32;
    let mut line = 0;
    let mut next = || {
        line += LEGEND_LINE;
        (left + 10, 50 + line)
    };
    let say = |text: &str, (x, y): (i32, i32)| area.draw(&Text::new(text.to_owned(), (x + 20, y - 10), (FONT, 19)));
    for tier in Tier::ALL.into_iter().filter(|tier| dots.iter().any(|dot| dot.tier == *tier)) {
        let at = next();
        mark(area, at, tier, true, false)?;
        say(tier.name(), at)?;
    }
    let (x, y) = next();
    area.draw(&PathElement::new([(x - 10, y), (x + 10, y)], FRONTIER.stroke_width(2)))?;
    say("frontier: nothing", (x, y))?;
    say("cheaper is better", (x, next().1 - LEGEND_LINE / 4))?;
    let at = next();
    mark(area, at, Tier::Point, false, false)?;
    say("not on it", at)?;
    if dots.iter().any(|dot| dot.recommended) {
        let at = next();
        area.draw(&Circle::new(at, DOTS.2 - 2, BLACK.stroke_width(2)))?;
        say("recommended", at)?;
    }
    Ok(())
}

/// Room that something takes: a line high \[pixels\].
struct Taken {
    left: i32,
    top: i32,
    width: i32,
}

/// A place beside a dot for a label of that width which nothing else has: right above, right below, left, and further down in lines.
fn free(taken: &mut Vec<Taken>, (x, y): (i32, i32), width: i32) -> (i32, i32) {
    const LINE: i32 = 17;
    let near = [(13, -20), (13, 4), (-13 - width, -20), (-13 - width, 4), (13, -8), (-13 - width, -8)];
    let places = near.into_iter().chain((1..12).flat_map(|i| [(13, 4 + i * LINE), (13, -20 - i * LINE)]));
    let clear = |&(left, top): &(i32, i32)| {
        taken.iter().all(|its| left + width < its.left || its.left + its.width < left || (top - its.top).abs() >= LINE)
    };
    let (left, top) = places.map(|(dx, dy)| (x + dx, y + dy)).find(clear).unwrap_or((x + 13, y - 20));
    taken.push(Taken { left, top, width });
    (left, top)
}
