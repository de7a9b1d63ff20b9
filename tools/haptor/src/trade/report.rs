//! A trade as text for people, as Markdown and as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::advice::{self, Limits};
use super::cost::{Times, VERTICES};
use super::errors::{Errors, Off};
use super::motions::Kind;
use super::point::{Point, Trade};

/// Heads of the columns; errors are largest (root mean square).
const HEADS: [&str; 13] = [
    "",
    "setting",
    "normal [%]",
    "twist [%]",
    "mixed [%]",
    "reversal [%]",
    "surface full [%]",
    "local [%]",
    "instructions",
    "p50 [us]",
    "worst [us]",
    "max [us]",
    "[kB]",
];

/// How tables are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Aligned columns.
    Plain,
    /// Markdown.
    Markdown,
}

/// The whole report.
pub fn text(trade: &Trade, limits: &Limits, style: Style) -> String {
    let mut text = head(trade, style);
    text += &table(&HEADS.map(str::to_owned), &trade.asked().map(|point| row(trade, point)).collect::<Vec<_>>(), style);
    let rates = rates(trade);
    if rates.len() > 1 {
        text += "\nWorst error by rate [%]:\n\n";
        let heads: Vec<String> = ["setting".to_owned()].into_iter().chain(rates.iter().map(|&rate| advice::rate(rate))).collect();
        let rows: Vec<Vec<String>> = trade.asked().map(|point| by_rate(trade, point, &rates)).collect();
        text += &table(&heads, &rows, style);
    }
    for note in &trade.notes {
        let _ = writeln!(text, "\n{note}");
    }
    let _ = writeln!(text, "\n{}", advice::words(trade, limits));
    text
}

fn head(trade: &Trade, style: Style) -> String {
    let Trade { scene, contacts, .. } = trade;
    let mark = if style == Style::Markdown { "## " } else { "" };
    let mut text = format!("{mark}{scene}\n\n");
    let units = &trade.units;
    let _ = writeln!(
        text,
        "{contacts} contact{}, pressed {:.3} mm: {:.3} N. Units of the motions: {:.3} mm of shift, {:.2} degrees of turn.",
        if *contacts == 1 { "" } else { "s" },
        1.0e3 * trade.depth,
        units.load,
        1.0e3 * units.shift,
        units.angle.to_degrees()
    );
    let _ = write!(text, "Truth: {}", trade.source);
    if let Some(own) = &trade.own {
        let p = |off: Off| format!("{:.1}", 100.0 * off.max);
        let _ = write!(
            text,
            "; a reference of fewer cells and steps differs by {} % (normal), {} (twist), {} (mixed), {} (reversal)",
            p(own.normal),
            p(own.twist),
            p(own.mixed),
            p(own.reversal)
        );
    }
    if trade.unconverged > 0 {
        let _ = write!(text, "; {} of its steps did not converge", trade.unconverged);
    }
    let _ = writeln!(
        text,
        ".\n\nErrors at {}, largest (root mean square); * on the frontier: nothing cheaper is better.\n",
        advice::rate(trade.rate)
    );
    text
}

fn row(trade: &Trade, point: &Point) -> Vec<String> {
    let off = |off: Off| format!("{:.1} ({:.1})", 100.0 * off.max, 100.0 * off.rms);
    let Errors { normal, twist, mixed, reversal } = point.errors;
    let mut row = vec![if trade.on_frontier(point) { "*" } else { "" }.to_owned(), point.setting.name()];
    row.extend([normal, twist, mixed, reversal, point.surface.full, point.surface.local].map(off));
    match point.cost {
        None => row.extend(vec!["-".to_owned(); 5]),
        Some(cost) => {
            row.push(cost.instructions.map_or("-".to_owned(), |count| count.to_string()));
            let times = cost.times.map(|times| [times.p50, times.worst, times.max].map(|time| format!("{time:.1}")));
            row.extend(times.unwrap_or_else(|| ["-"; 3].map(str::to_owned)));
            row.push(format!("{:.0}", cost.bytes as f64 / 1000.0));
        }
    }
    row
}

fn rates(trade: &Trade) -> Vec<f64> {
    let mut rates: Vec<f64> = trade.points.iter().map(|point| point.rate).collect();
    rates.sort_by(f64::total_cmp);
    rates.dedup();
    rates
}

fn by_rate(trade: &Trade, point: &Point, rates: &[f64]) -> Vec<String> {
    let at = |rate: f64| {
        let found = trade.points.iter().find(|other| other.setting == point.setting && other.rate == rate);
        found.map_or("-".to_owned(), |found| format!("{:.1}", 100.0 * found.errors.worst()))
    };
    [point.setting.name()].into_iter().chain(rates.iter().map(|&rate| at(rate))).collect()
}

/// Columns as wide as their widest entry, words to the left, numbers to the right.
fn table(heads: &[String], rows: &[Vec<String>], style: Style) -> String {
    let wide = |column: usize| rows.iter().map(|row| row[column].len()).chain([heads[column].len()]).max().unwrap_or(0);
    let widths: Vec<usize> = (0..heads.len()).map(wide).collect();
    let named = heads.iter().position(|head| head == "setting").unwrap_or(0);
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(column, (cell, width))| if column <= named { format!("{cell:width$}") } else { format!("{cell:>width$}") })
            .collect();
        match style {
            Style::Plain => format!("{}\n", cells.join("  ").trim_end()),
            Style::Markdown => format!("| {} |\n", cells.join(" | ")),
        }
    };
    let mut text = line(heads);
    if style == Style::Markdown {
        let rule = |(column, width): (usize, &usize)| {
            if column <= named { "-".repeat(*width + 2) } else { format!("{}:", "-".repeat(*width + 1)) }
        };
        let _ = writeln!(text, "|{}|", widths.iter().enumerate().map(rule).collect::<Vec<_>>().join("|"));
    }
    rows.iter().for_each(|row| text += &line(row));
    text
}

/// Everything as one JSON object: errors as shares, times in microseconds.
pub fn json(trade: &Trade, limits: &Limits) -> Value {
    let chosen = advice::choose(trade, limits);
    json!({
        "scene": trade.scene,
        "depth_m": trade.depth,
        "contacts": trade.contacts,
        "load_N": trade.units.load,
        "shift_unit_m": trade.units.shift,
        "angle_unit_rad": trade.units.angle,
        "truth": trade.source,
        "truth_coarser_by": trade.own.map(|own| errors(&own)),
        "unconverged": trade.unconverged,
        "rate_Hz": trade.rate,
        "notes": trade.notes,
        "points": trade.points.iter().map(|point| point_json(trade, point)).collect::<Vec<_>>(),
        "recommended": chosen.map(|point| point.setting.name()),
        "recommendation": advice::words(trade, limits),
    })
}

fn off(off: Off) -> Value {
    json!({ "max": off.max, "rms": off.rms })
}

fn errors(errors: &Errors) -> Value {
    let Errors { normal, twist, mixed, reversal } = *errors;
    json!({ "normal": off(normal), "twist": off(twist), "mixed": off(mixed), "reversal": off(reversal) })
}

fn point_json(trade: &Trade, point: &Point) -> Value {
    let times = |times: Times| {
        json!({
            "ticks": times.ticks, "p50_us": times.p50, "p99_us": times.p99, "worst_us": times.worst, "max_us": times.max,
            "surface_vertices": VERTICES, "surface_local_us": times.surface_local, "surface_full_us": times.surface_full,
        })
    };
    let cost = point
        .cost
        .map(|cost| json!({ "worst_instructions": cost.instructions, "bytes": cost.bytes, "times": cost.times.map(times) }));
    json!({
        "setting": point.setting.name(),
        "tier": point.setting.tier.name(),
        "samples": point.setting.samples,
        "sweeps": point.setting.sweeps_cells().then_some(point.setting.sweeps),
        "rate_Hz": point.rate,
        "errors": errors(&point.errors),
        "surface": {
            "none": { "max": 1.0 }, "local": off(point.surface.local), "full": off(point.surface.full),
            "farthest_after": point.surface.farthest.after.map_or("pressing", Kind::name),
            "farthest_at_m": point.surface.farthest.place.to_array(),
        },
        "cost": cost,
        "share_of_period": point.share(),
        "frontier": trade.on_frontier(point),
    })
}
