//! Time per tick: middle, 99 of 100, longest, and against ours in the same round.

use std::fmt::Write;

use crate::lines::{Lines, Time};
use crate::{DEFAULT, OURS};

/// Times of one case over all rounds.
#[derive(Debug)]
pub struct Case<'a> {
    pub peer: &'a str,
    pub case: &'a str,
    pub n: usize,
    pub wall_us: f64,
    pub median_us: f64,
    pub p99_us: f64,
    pub max_us: f64,
    /// Times ours, in the middle of the rounds.
    pub ratio: f64,
}

/// Every case of a scene.
pub fn cases<'a>(lines: &'a Lines, scene: &str) -> Vec<Case<'a>> {
    let times: Vec<Time> = lines.times.iter().filter(|time| time.scene == scene).cloned().collect();
    let ours = |round| times.iter().find(|time| time.round == round && time.peer == OURS && time.case == DEFAULT);
    let names = Lines::cases(&lines.times, |time| (time.peer.as_str(), time.case.as_str()));
    let one = |(peer, case): (&'a str, &'a str)| {
        let rounds: Vec<_> = times.iter().filter(|time| time.peer == peer && time.case == case).collect();
        let all = |of: fn(&Time) -> f64| middle(rounds.iter().map(|time| of(time)));
        let ratios = rounds.iter().filter_map(|time| Some(time.cpu_median_us / ours(time.round)?.cpu_median_us));
        (!rounds.is_empty()).then(|| Case {
            peer,
            case,
            n: rounds.iter().map(|time| time.n).sum(),
            wall_us: all(|time| time.median_us),
            median_us: all(|time| time.cpu_median_us),
            p99_us: all(|time| time.cpu_p99_us),
            max_us: rounds.iter().fold(0.0, |max: f64, time| max.max(time.cpu_max_us)),
            ratio: middle(ratios),
        })
    };
    names.into_iter().filter_map(one).collect()
}

/// The middle value; of an even number the lower of the two.
fn middle(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN)
}

/// Three digits.
pub fn short(value: f64) -> String {
    match value {
        v if v >= 99.95 => format!("{v:.0}"),
        v if v >= 9.995 => format!("{v:.1}"),
        v => format!("{v:.2}"),
    }
}

/// The ball on the cube.
pub fn one_region(lines: &Lines) -> String {
    let mut text = ONE.to_owned();
    for case in cases(lines, "ball-on-cube") {
        let Case { peer, case, n, wall_us, median_us, p99_us, max_us, ratio } = case;
        let numbers = [median_us, p99_us, max_us, wall_us, ratio].map(short).join(" | ");
        let good = if p99_us < 1000.0 { "yes" } else { "no" };
        let _ = writeln!(text, "| {peer} | {case} | {numbers} | {good} | {n} |");
    }
    text
}

const ONE: &str = "\
## Time: the ball on the cube

Microseconds a tick; 1 kHz says whether 99 of 100 ticks stay within a millisecond of CPU time.

| program | case | CPU median | CPU p99 | CPU max | wall median | times `bristle 64` | 1 kHz | n |
|---|---|---:|---:|---:|---:|---:|---|---:|
";

/// One to ten balls.
pub fn regions(lines: &Lines) -> String {
    let mut text = MANY.to_owned();
    for body in ["box", "ellipsoid"] {
        let columns = [1, 2, 5, 10].map(|count| cases(lines, &format!("{body}-k{count}")));
        for first in &columns[0] {
            let of = |column: &Vec<Case<'_>>| {
                let found = column.iter().find(|case| (case.peer, case.case) == (first.peer, first.case));
                found.map_or("-".to_owned(), |case| format!("{} / {}", short(case.median_us), short(case.p99_us)))
            };
            let _ = writeln!(text, "| {body} | {} | {} | {} |", first.peer, first.case, columns.each_ref().map(of).join(" | "));
        }
    }
    text
}

const MANY: &str = "\
## Time: one to ten regions

CPU microseconds a tick, median / p99, for k balls of 10 mm, pressed 0.7 to 1.3 mm, shifted and twisted.

| object | program | case | k = 1 | k = 2 | k = 5 | k = 10 |
|---|---|---|---:|---:|---:|---:|
";

/// The shipped scenes, which only ours runs.
pub fn shipped(lines: &Lines) -> String {
    let mut text = SHIPPED.to_owned();
    let columns = ["cube-twist", "mallet", "compass", "ten-regions"].map(|scene| cases(lines, scene));
    for first in &columns[0] {
        let of = |column: &Vec<Case<'_>>| {
            let found = column.iter().find(|case| case.case == first.case);
            found.map_or("-".to_owned(), |case| format!("{} / {}", short(case.median_us), short(case.p99_us)))
        };
        let _ = writeln!(text, "| {} | {} |", first.case, columns.each_ref().map(of).join(" | "));
    }
    text
}

const SHIPPED: &str = "\
## Time: the shipped scenes

haptor alone; CPU microseconds of a tick in contact, median / p99.

| tier | cube-twist | mallet | compass | ten-regions |
|---|---:|---:|---:|---:|
";
