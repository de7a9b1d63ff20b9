//! Force and torque against the same truth.

use std::f64::consts::PI;
use std::fmt::Write;

use crate::lines::{Drag, Lines, Press};

/// Coefficient of friction of every case.
const FRICTION: f64 = 0.75;

/// Depth of the drag with twist.
const DRAG_DEPTH_MM: f64 = 3.0;

/// How far a case is off at one depth, in per cent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    pub depth_mm: f64,
    /// Of the true force.
    pub force: f64,
    /// Of the true torque at the smallest twist of the truth.
    pub stick: f64,
    /// Of the true torque at the largest.
    pub slip: f64,
    /// Largest over all twists, of the largest true torque.
    pub curve: f64,
    /// Torque after the hold, of that before.
    pub held: f64,
}

/// The errors of a press; `None` without its truth.
fn errors(lines: &Lines, press: &Press) -> Option<Errors> {
    let truth = lines.truth(press.nu, press.depth_mm)?;
    let off = |found: f64, wanted: f64| 100.0 * (found / wanted - 1.0);
    let pairs = || press.torque_Nm.iter().zip(&truth.torque_Nm);
    let (first, last) = (pairs().next()?, pairs().next_back()?);
    let worst = pairs().map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max);
    Some(Errors {
        depth_mm: press.depth_mm,
        force: off(press.force_N, truth.force_N),
        stick: off(*first.0, *first.1),
        slip: off(*last.0, *last.1),
        curve: 100.0 * worst / last.1,
        held: 100.0 * press.held,
    })
}

/// Programs and cases with their errors at each depth.
pub fn all(lines: &Lines) -> Vec<(&str, &str, Vec<Errors>)> {
    let names = Lines::cases(&lines.presses, |press| (press.peer.as_str(), press.case.as_str()));
    let of = |(peer, case)| {
        let own = lines.presses.iter().filter(|press| press.peer == peer && press.case == case);
        (peer, case, own.filter_map(|press| errors(lines, press)).collect())
    };
    names.into_iter().map(of).collect()
}

/// The table of the press and the twist.
pub fn table(lines: &Lines) -> String {
    let mut text = TABLE.to_owned();
    for (peer, case, errors) in all(lines) {
        let join = |of: fn(&Errors) -> f64, sign: bool| {
            let one = |value: f64| match value {
                v if v >= 1000.0 => "> 1000".to_owned(),
                v if sign => format!("{v:+.1}"),
                v => format!("{v:.1}"),
            };
            errors.iter().map(|errors| one(of(errors))).collect::<Vec<_>>().join(" / ")
        };
        let columns = [
            join(|e| e.force, true),
            join(|e| e.stick, true),
            join(|e| e.slip, true),
            join(|e| e.curve, false),
            join(|e| e.held, false),
        ];
        let _ = writeln!(text, "| {peer} | {case} | {} |", columns.join(" | "));
    }
    text
}

const TABLE: &str = "\
## Force and torque against the truth

A ball of 20 mm on the rubber cube of 0.1 m, pressed 1 / 3 / 5 mm, then twisted to 60 degrees at 120 degrees a second and held for half a second. Errors in per cent of the finite elements'
value at the program's own Poisson's ratio. *Stick*: torque at 0.25 degrees; *slip*: at 60; *curve*: largest error at 13 twists in between, of the torque at 60; *held*: what is left of the
torque after the hold (100: all; the truth does not relax).

| program | case | force | stick | slip | curve | held |
|---|---|---:|---:|---:|---:|---:|
";

/// Programs and cases with drag / (mu F) and torque / (full-slip torque).
pub fn drags(lines: &Lines) -> Vec<(&str, &str, [f64; 2])> {
    let shares = |drag: &Drag| {
        let truth = lines.truth(drag.nu, DRAG_DEPTH_MM)?;
        // full slip at the program's own load: the contact radius is the truth's
        let full = truth.torque_Nm.last()? * drag.normal_N / truth.force_N;
        Some([drag.drag_N / (FRICTION * drag.normal_N), drag.torque_Nm / full])
    };
    lines.drags.iter().filter_map(|drag| Some((drag.peer.as_str(), drag.case.as_str(), shares(drag)?))).collect()
}

/// The table of the drag with twist.
pub fn drag(lines: &Lines) -> String {
    let [force, torque] = lines.run.sliding;
    let mut text = format!("{DRAG}| truth | Coulomb friction under Hertz pressure | {force:.3} | {torque:.3} |\n");
    for (peer, case, [drag, twist]) in drags(lines) {
        let _ = writeln!(text, "| {peer} | {case} | {drag:.3} | {twist:.3} |");
    }
    text + &format!("\nThe full-slip torque is 3 pi/16 mu F a = {:.3} mu F a.\n", 3.0 * PI / 16.0)
}

const DRAG: &str = "\
## Twist while dragging

At 3 mm, the ball is dragged over two contact radii while it turns by two radians, so that the rim turns as fast as the centre slides. Sliding eats the torque: friction has one budget.
Drag as a share of mu F, torque as a share of the full-slip torque, at the end.

| program | case | drag / (mu F) | torque / full slip |
|---|---|---:|---:|
";
