//! Motions that are always measured: those of `tests/bench/COUNTS.md` on the scene's own probe, and one for every condition that a tick can be in.

use core::f32::consts::FRAC_PI_4;

use haptor_contact::{MAX_WORK, MIN_WORK, Pose, ProbeFrame, Quat, Vec3, World};
use haptor_wire::{ForceLaw, GuardLimits, Passivity, Tier, Tuning};

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
        history("poses that are none", start, |tick| {
            let pose = led(start, tick, PRESS.0, 1.0, TURN * Vec3::Z);
            if tick % 8 == 5 { Pose::new(Vec3::NAN, pose.rotation) } else { pose }
        }),
        history("jumps that are refused", start, |tick| {
            let pose = led(start, tick, PRESS.0, 1.0, FRAC_PI_4 * Vec3::Z);
            if tick % 8 == 5 { Pose::new(pose.position + JUMP * Vec3::X, pose.rotation) } else { pose }
        }),
    ]
}

/// Motions under settings of their own, one for each branch that the scene's settings leave out; whatever a user may set is set.
fn set_otherwise(most: &Start, level: &Tuning) -> Vec<History> {
    let under = |name: &str, tuning: Tuning, pose: &dyn Fn(usize) -> Pose<World, ProbeFrame>| History {
        tunings: vec![(0, tuning)],
        ..history(name, most, pose)
    };
    let press = |tick| led(most, tick, PRESS.0, 1.0, TURN * Vec3::Z);
    // in fast and out fast, so that a sampled contact gives out more than it takes
    let bounce = |tick: usize| most.pose(if tick % 4 < 2 { 2.0 * PRESS.0 } else { 0.2 * PRESS.0 });
    // friction of the largest number there is overflows: the last net catches what is not finite
    let mut force = [f32::MAX; 16];
    force[0] = 0.0;
    let law = ForceLaw::Table { step: 1.0e-6, force };
    let mut motions = vec![
        under("less work than any rung", Tuning { work: Some(MIN_WORK), ..*level }, &press),
        under("work to spare", Tuning { work: Some(MAX_WORK), ..*level }, &press),
        under("passivity kept", Tuning { guard: GuardLimits { passivity: Some(WATCHED), ..level.guard }, ..*level }, &bounce),
        under("limits of a weak device", Tuning { guard: GuardLimits { max_torque: WEAK, ..level.guard }, ..*level }, &press),
        under(
            "a force law beyond all forces",
            Tuning { force_law: law, friction_static: MAX_FRICTION, friction_dynamic: MAX_FRICTION, ..*level },
            &press,
        ),
    ];
    if most.parts > 1 {
        let limited = Tuning { max_regions: 1, ..*level };
        motions.push(under("more regions than allowed", limited, &|tick| led(most, tick, PRESS.0, 1.0, TURN * Vec3::Y)));
        motions.push(under("one region of all patches", Tuning { region_distance: ALL, ..*level }, &press));
    }
    motions
}

/// Torque limit that every contact with friction exceeds \[N m\].
const WEAK: f32 = 1.0e-5;

/// The most friction that may be set.
const MAX_FRICTION: f32 = 10.0;

/// Patches nearer to each other than this are one region \[m\]: all are.
const ALL: f32 = 10.0;

/// The observer of energy as the core has it by default, without allowance.
const WATCHED: Passivity = Passivity { max_damping: 5.0, max_spin_damping: 0.004, allowance: 0.0, reserve: 0.1, delay_ticks: 0 };

/// A twist about the line from the probe's mass centre through its first part, which lies at the middle of the base.
fn twisted_at_the_base(below: &Start) -> History {
    let axis = below.pose(PRESS.0).position.normalize_or(Vec3::Z);
    history("twist at the base", below, |tick| led(below, tick, PRESS.0, 0.0, TURN * axis))
}

/// Motions for a scene with another coupling.
pub fn coupled(starts: &[Start]) -> Vec<History> {
    starts.last().into_iter().flat_map(at).chain(starts.last().into_iter().flat_map(once)).collect()
}

/// Every fixed motion of a scene at a level; `others` are the tunings of the other levels, `below` a start from below.
pub fn all(starts: &[Start], below: Option<&Start>, level: &Tuning, others: &[Tuning]) -> Vec<History> {
    let (Some(first), Some(most)) = (starts.first(), starts.last()) else { return Vec::new() };
    let mut motions = at(first);
    if most.parts > first.parts {
        motions.extend(at(most));
    }
    motions.extend(once(most));
    motions.extend(set_otherwise(most, level));
    // the one tier that asks how far the contact is from the middle of the base
    motions.extend(below.filter(|_| level.tier == Tier::Paper).map(twisted_at_the_base));
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
