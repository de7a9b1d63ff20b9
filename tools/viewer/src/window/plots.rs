//! The panel at the right: force, torque, depth and the time of a tick over the last seconds, all over one axis of time.

use eframe::egui::{self, Color32, Rangef, RichText, vec2};
use egui_plot::{AxisHints, GridInput, GridMark, HLine, Line, LineStyle, Plot};

use super::app::{App, SPANS};
use super::style::{self, AXES, NORM, faint};
use crate::feed::{Channel, History};
use crate::picture::{Quantity, Unit, decimals, figure, round_step};

/// Width of the panel at first, and what it can be drawn to \[points\].
pub const WIDTH: f32 = 360.0;
/// Likewise.
pub const WIDTHS: std::ops::RangeInclusive<f32> = 260.0..=800.0;

/// Room for the figures at the axis \[points\].
const AXIS: f32 = 56.0;

/// Height of the line of figures above a plot \[points\].
const HEADING: f32 = 24.0;

/// Height of the figures and words below the last plot \[points\].
const FOOT: f32 = 38.0;

/// Distances of figures at the axes of time and of values, from where they appear to where they are full \[points\].
const LABELS: (Rangef, Rangef) = (Rangef { min: 36.0, max: 44.0 }, Rangef { min: 14.0, max: 20.0 });

/// Parts into which marks divide the axes of time and of values, at least.
const PARTS: (f64, f64) = (4.0, 2.5);

/// Lines behind the curves.
const GRID: Color32 = Color32::from_rgb(110, 116, 128);

/// A plot is not lower than this \[points\].
const LEAST: f32 = 70.0;

/// Force \[N\], torque \[N m\] and depth \[m\] below which the units do not become smaller: what is less is not felt.
const QUIET: (f64, f64, f64) = (1.0, 1.0e-3, 1.0e-3);

/// A curve: what, its name, its colour.
type Curve = (Channel, &'static str, Color32);

/// A plot.
struct Sheet {
    title: &'static str,
    /// Unit and units in one of the history's.
    unit: &'static str,
    per_si: f64,
    curves: Vec<Curve>,
    /// A line that should not be passed, in the history's unit.
    limit: Option<f64>,
}

/// Shows the panel.
pub fn show(ui: &mut egui::Ui, app: &mut App) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new("Last").strong());
        for span in SPANS {
            ui.selectable_value(&mut app.span, span, format!("{span} s"));
        }
    });
    let sheets = sheets(app);
    let height = (ui.available_height() - FOOT) / sheets.len() as f32 - HEADING - ui.spacing().item_spacing.y;
    let last = sheets.len() - 1;
    for (number, sheet) in sheets.iter().enumerate() {
        show_heading(ui, sheet, &app.history);
        let foot = if number == last { FOOT } else { 0.0 };
        show_sheet(ui, sheet, app, height.max(LEAST) + foot, number == last);
    }
}

fn axes(of: fn(usize) -> Channel, norm: Channel) -> Vec<Curve> {
    let [x, y, z] = AXES;
    vec![(of(0), "x", x), (of(1), "y", y), (of(2), "z", z), (norm, "total", NORM)]
}

fn sheets(app: &App) -> Vec<Sheet> {
    let [force, torque, depth] = [
        (Quantity::Force, Channel::ForceNorm, QUIET.0),
        (Quantity::Torque, Channel::TorqueNorm, QUIET.1),
        (Quantity::Length, Channel::Depth, QUIET.2),
    ]
    .map(|(quantity, channel, quiet)| quantity.unit(largest(app, channel).max(quiet)));
    let budget = app.scene.stage().map(|stage| stage.step_budget_us).filter(|budget| *budget > 0.0);
    let sheet = |title, unit: Unit, curves| Sheet { title, unit: unit.name, per_si: unit.per_si, curves, limit: None };
    vec![
        sheet("Force", force, axes(Channel::Force, Channel::ForceNorm)),
        sheet("Torque", torque, axes(Channel::Torque, Channel::TorqueNorm)),
        sheet("Depth", depth, vec![(Channel::Depth, "", AXES[2])]),
        Sheet { title: "Step", unit: "\u{b5}s", per_si: 1.0, curves: vec![(Channel::Step, "", AXES[1])], limit: budget },
    ]
}

/// The times shown \[s\]: the newest sample at the right edge.
fn times(app: &App) -> (f64, f64) {
    let end = app.history.last().map_or(0.0, |sample| sample.time).max(app.span);
    (end - app.span, end)
}

fn largest(app: &App, channel: Channel) -> f64 {
    let (from, to) = times(app);
    app.history.curve(channel, from, to, 1).iter().map(|point| point[1].abs()).fold(0.0, f64::max)
}

/// Name, unit and the newest values in the colours of their curves.
fn show_heading(ui: &mut egui::Ui, sheet: &Sheet, history: &History) {
    ui.horizontal(|ui| {
        ui.set_height(HEADING - ui.spacing().item_spacing.y);
        ui.label(RichText::new(sheet.title).strong());
        ui.label(faint(format!("[{}]", sheet.unit)));
        for (channel, name, colour) in &sheet.curves {
            let value = history.last().map(|sample| channel.of(sample)).filter(|value| value.is_finite());
            let words = value.map_or("no clock".to_owned(), |value| figure(value * sheet.per_si));
            ui.label(RichText::new(format!("{name} {words}").trim_start()).color(*colour));
        }
        if let Some(limit) = sheet.limit {
            ui.label(RichText::new(format!("- - budget {limit:.0}")).color(style::WARNING));
        }
    });
}

fn show_sheet(ui: &mut egui::Ui, sheet: &Sheet, app: &App, height: f32, is_last: bool) {
    let (from, to) = times(app);
    let columns = (ui.available_width() - AXIS).max(1.0) as usize;
    let value = AxisHints::new_y().label(format!("{} [{}]", sheet.title.to_lowercase(), sheet.unit));
    let time = AxisHints::new_x().label("time [s]").label_spacing(LABELS.0).formatter(written);
    let plot = Plot::new(sheet.title)
        .height(height)
        .show_axes([is_last, true])
        .custom_y_axes(vec![value.min_thickness(AXIS).label_spacing(LABELS.1).formatter(written)])
        .custom_x_axes(vec![time])
        .x_grid_spacer(|input| marks(input, PARTS.0))
        .y_grid_spacer(|input| marks(input, PARTS.1))
        .grid_color(GRID)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .set_margin_fraction(vec2(0.0, 0.08))
        .show_x(true)
        .include_y(0.0);
    plot.show(ui, |plot| {
        plot.set_plot_bounds_x(from..=to);
        plot.set_auto_bounds([false, true]);
        for (channel, name, colour) in &sheet.curves {
            let curve = app.history.curve(*channel, from, to, columns);
            let points: Vec<[f64; 2]> = curve.into_iter().map(|[time, value]| [time, value * sheet.per_si]).collect();
            plot.line(Line::new(*name, points).color(*colour).width(1.6));
        }
        if let Some(limit) = sheet.limit {
            plot.hline(HLine::new("budget", limit).color(style::WARNING).style(LineStyle::dashed_dense()));
        }
    });
}

/// The figure at a mark, as finely as the marks are apart.
fn written(mark: GridMark, _: &std::ops::RangeInclusive<f64>) -> String {
    format!("{:.*}", decimals(mark.step_size), mark.value)
}

/// Round marks along an axis.
fn marks(input: GridInput, parts: f64) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let step_size = round_step((high - low) / parts);
    let first = (low / step_size).ceil();
    // no more than fit: bounds may be anything before the first picture
    let count = ((high / step_size).floor() - first).clamp(0.0, 20.0) as u32;
    (0..=count).map(|k| GridMark { value: (first + f64::from(k)) * step_size, step_size }).collect()
}
