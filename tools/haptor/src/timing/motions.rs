//! Motions that are always measured: those of `tests/bench/COUNTS.md` on the scene's own probe, and one for every condition that a tick can be in.

use core::f32::consts::FRAC_PI_4;

use haptor_contact::{Pose, ProbeFrame, Quat, Vec3, World};
use haptor_wire::Tuning;

use super::history::History;
use super::start::Start;

/// Ticks of a motion: a multiple of the periods below.
const TICKS: usize = 48;

/// Depth about which the motions press \[m\], and by how much they go up and down.
const PRESS: (f32, f32) = (1.0e-3, 4.0e-4);

/// Shift along x and y \[m\], and turn \[rad\]: contacts of rubber stick and slip.
const SHIFT: (f32, f32) = (1.0e-3, 7.0e-4);
const TURN: f32 = 0.1;

/// A jump that no hand makes \[m\].
const JUMP: f32 = 10.0;

/// From 1 to -1 and back, straight.
fn wave(tick: usize, period: usize) -> f32 {
    let share = (tick % period) as f32 / period as f32;
    1.0 - 4.0 * (share - 0.5).abs()
}

/// Presses, slides and turns by shares of the figures above.
fn led(start: &Start, tick: usize, depth: f32, shift: f32, turn: Vec3) -> Pose<World, ProbeFrame> {
    let at = start.pose(depth - PRESS.1 * wave(tick, 16));
    let way = Vec3::new(SHIFT.0 * wave(tick, 48), SHIFT.1 * wave(tick, 24), 0.0) * shift;
    Pose::new(at.position + way, (Quat::from_scaled_axis(wave(tick, 48) * turn) * at.rotation).normalize())
}

fn history(name: &str, start: &Start, pose: impl Fn(usize) -> Pose<World, ProbeFrame>) -> History {
    let parts = match start.parts {
        1 => "one part".to_owned(),
        parts => format!("{parts} parts"),
    };
    History { name: format!("{name}, {parts}"), poses: (0..TICKS).map(pose).collect(), tunings: Vec::new() }
}

/// Motions of one start.
fn at(start: &Start) -> Vec<History> {
    let (twist, roll) = (TURN * Vec3::Z, 0.2 * TURN * Vec3::X);
    vec![
        history("press and slide", start, |tick| led(start, tick, PRESS.0, 1.0, Vec3::ZERO)),
        history("press, slide and twist", start, |tick| led(start, tick, PRESS.0, 1.0, twist)),
        history("roll", start, |tick| led(start, tick, PRESS.0, 0.3, roll)),
        // lifted clear every third round of the press
        history("in and out", start, |tick| led(start, tick, if tick % 12 < 9 { PRESS.0 } else { -PRESS.0 }, 1.0, twist)),
        history("slow descent", start, |tick| start.pose(PRESS.0 * (tick as f32 / 24.0 - 0.5))),
        history("deep press", start, |tick| led(start, tick, 5.0 * PRESS.0, 2.0, 4.0 * twist)),
    ]
}

/// Motions that need one start only.
fn once(start: &Start) -> Vec<History> {
    vec![
        history("no contact", start, |tick| led(start, tick, -0.01, 1.0, TURN * Vec3::Z)),
        history("held still", start, |_| start.pose(PRESS.0)),
        history("jumps that are refused", start, |tick| {
            let pose = led(start, tick, PRESS.0, 1.0, FRAC_PI_4 * Vec3::Z);
            if tick % 8 == 5 { Pose::new(pose.position + JUMP * Vec3::X, pose.rotation) } else { pose }
        }),
    ]
}

/// Every fixed motion of a scene at a level; `others` are the tunings of the other levels.
pub fn all(starts: &[Start], level: &Tuning, others: &[Tuning]) -> Vec<History> {
    let (Some(first), Some(most)) = (starts.first(), starts.last()) else { return Vec::new() };
    let mut motions = at(first);
    if most.parts > first.parts {
        motions.extend(at(most));
        let limited = Tuning { max_regions: 1, ..*level };
        let full = history("more regions than allowed", most, |tick| led(most, tick, PRESS.0, 1.0, TURN * Vec3::Y));
        motions.push(History { tunings: vec![(0, limited)], ..full });
    }
    motions.extend(once(most));
    if !others.is_empty() {
        let changing = history("tier after tier", most, |tick| led(most, tick, PRESS.0, 1.0, TURN * Vec3::Z));
        motions.push(History { tunings: changes(level, others), ..changing });
    }
    motions
}

/// Every eighth tick another tier, and back after four.
fn changes(level: &Tuning, others: &[Tuning]) -> Vec<(usize, Tuning)> {
    let there_and_back = |(k, tick): (usize, usize)| [(tick, others[k % others.len()]), (tick + 4, *level)];
    (12..TICKS - 4).step_by(8).enumerate().flat_map(there_and_back).collect()
}
