//! The work budget of a tick, and the ladder that keeps to it.
//!
//! **Words.** *Work* is counted in *units*: one is an instruction of the x86-64 release build, so that it is known before a tick what it may cost, whatever the machine
//! and its other work. What a unit takes on a machine, a host measures. An *estimate* is an upper bound from counts (parts near the object, patches, samples,
//! sweeps) times unit costs (`costs.rs`). A *rung* is a setting of tier, samples and sweeps ([`Rung`]); the highest is what the parameters ask for.
//!
//! Where a budget is set, each tick picks its rung once its patches are pressed and before friction is computed. A rung that does not fit is left **at once**, as many
//! steps down as it takes; a higher one is gone back to **one step** after [`CALM_TICKS`] ticks in a row in which it would have fitted with a margin ([`MARGIN`]). The order in
//! which a tick gives way:
//!
//! 1. the surface that somebody looks at, which gets what the tick has left ([`deform`](crate::deform));
//! 2. the looks at parts that were looked at lately: the parts take **turns**, a quarter of them a tick, and the contacts of the others go with their parts (`turns.rs`);
//! 3. the grip's rungs;
//! 4. the second pass of pressing after a birth;
//! 5. the samples that the search of meshes asks, where that and the lowest rung do not fit together;
//! 6. more of the looks, down to one part a tick.
//!
//! What is left when all has given way is done, and the report's work says that it is more than the budget. A tick in which anything but the surface gave way is flagged
//! [`TIER_LOWERED`](crate::Flags::TIER_LOWERED).
//!
//! The same budget, poses and settings give the same rungs on every machine, so a recording computed again comes out to the bit. A change of rung carries
//! the force over: what a patch holds is what the other tier, or the other grid, begins with.
//!
//! Degrading by level of detail before a deadline, not after it, is what Barbic and James did for contact of point shells with distance fields (2007, 2008).

mod costs;
mod estimate;
mod rung;
mod turns;

pub use estimate::{of_surface, of_vertex};
pub use rung::Rung;
pub(crate) use turns::Turns;

use crate::frames::{Pose, ProbeFrame, World};
use crate::geometry::support::ASKED_SAMPLES;
use crate::limits::{MAX_PARTS, MIN_SAMPLES};
use crate::model::Model;
use crate::params::Params;
use crate::patch::Patch;
use crate::report::Flags;
use crate::stage::detect::{Parts, near};
use crate::stage::force::{Passes, Pressed};
use crate::state::Memory;
use estimate::Counts;
use rung::MAX_STEPS;
use turns::{Room, Round, Turn};

/// Ticks in a row in which the next rung up must fit before it is taken: a tenth of a second at 1 kHz, longer than a contact that chatters.
pub const CALM_TICKS: u8 = 100;

/// Share of the budget, as a divisor, that must stay free on the next rung up: a sixteenth, more than what a contact takes wanders by while it slides.
pub const MARGIN: u32 = 16;

/// Halvings of the samples asked: from 256 to 16, below which a search may begin at the wrong side of a body.
const SEARCH_STEPS: u8 = (ASKED_SAMPLES / MIN_SAMPLES).ilog2() as u8;

/// Where a ladder stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Ladder {
    /// Steps below the highest rung.
    steps: u8,
    /// Ticks in a row in which the next rung up fitted.
    calm: u8,
    /// This tick's rung is not that of the tick before.
    moved: bool,
}

impl Ladder {
    /// It stays where it is while counts and room do.
    const fn is_settled(&self) -> bool {
        self.calm == 0 && !self.moved
    }

    const TOP: Self = Self { steps: 0, calm: 0, moved: false };

    /// Goes down to the first rung that fits into `room`, at most to the `lowest`, or up by one when that has fitted long enough.
    fn settle(&mut self, room: u32, lowest: u8, cost: impl Fn(u8) -> u32) -> u8 {
        let before = self.steps.min(lowest);
        self.steps = before;
        for steps in before..=lowest {
            self.steps = steps;
            if cost(steps) <= room {
                break;
            }
        }
        if self.steps > before || before == 0 || cost(before - 1) > room - room / MARGIN {
            self.calm = 0;
        } else if self.calm + 1 < CALM_TICKS {
            self.calm += 1;
        } else {
            (self.steps, self.calm) = (before - 1, 0);
        }
        self.moved = self.steps != before;
        self.steps
    }
}

/// What the budget remembers from tick to tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Account {
    grip: Ladder,
    search: Ladder,
    /// What the steps of the grip are counted from.
    wanted: Option<Rung>,
    /// Whose turn it is to be looked at.
    round: Round,
    /// Estimate of what friction took in the last tick.
    held: u32,
    /// Estimate of the last tick; 0 without a budget.
    pub work: u32,
}

impl Account {
    /// Without history.
    pub const NEW: Self =
        Self { grip: Ladder::TOP, search: Ladder::TOP, wanted: None, round: [Turn::NONE; MAX_PARTS], held: 0, work: 0 };

    /// The ladders stay where they are while nothing moves, and no part waits.
    pub fn is_settled(&self) -> bool {
        self.grip.is_settled() && self.search.is_settled() && self.round.iter().all(|turn| turn.waited == 0)
    }
}

/// The turns of a tick that may spend `work`, at probe pose `x_wp`.
#[cold]
#[inline(never)]
pub(crate) fn turns_within(
    work: u32,
    model: &Model<'_>,
    params: &Params,
    account: &mut Account,
    x_wp: &Pose<World, ProbeFrame>,
) -> Turns {
    let near = near(model, x_wp);
    let lowest = estimate::of_dearest_grip(model, params, params.rung.below(MAX_STEPS), near.count());
    let beside = estimate::beside_looks(model, params, near);
    let asked = samples_to_ask(model, account, near, work.saturating_sub(beside).saturating_sub(lowest));
    let room = |grip: u32| work.saturating_sub(beside).saturating_sub(grip);
    let room = Room { beside: room(account.held.max(lowest)), most: room(lowest) };
    Turns::new(near, asked, room, account.round)
}

/// Samples that a mesh is asked in this tick: fewer where the search and the lowest rung do not fit together.
fn samples_to_ask(model: &Model<'_>, account: &mut Account, near: Parts, room: u32) -> usize {
    if !model.probe.iter().any(estimate::is_mesh) {
        return ASKED_SAMPLES;
    }
    let asked = |steps: u8| ASKED_SAMPLES >> steps;
    asked(account.search.settle(room, SEARCH_STEPS, |steps| estimate::of_search(model, near, asked(steps))))
}

/// How often the patches are pressed: as often as they need it where there is no budget, or that fits beside the lowest rung.
#[inline]
pub(crate) fn passes(model: &Model<'_>, params: &Params, turns: Option<&Turns>, patches: &[Patch]) -> Passes {
    let passes = Passes::of(patches);
    match (params.work, turns) {
        (Some(work), Some(turns)) if passes.newborn => passes_within(work, model, params, turns, (patches, passes)),
        _ => passes,
    }
}

#[cold]
#[inline(never)]
fn passes_within(work: u32, model: &Model<'_>, params: &Params, turns: &Turns, (patches, passes): (&[Patch], Passes)) -> Passes {
    let lowest = estimate::of_dearest_grip(model, params, params.rung.below(MAX_STEPS), patches.len());
    let whole = estimate::of_contacts(model, params, &Counts::new(turns, patches, passes.at_most(patches.len())));
    if whole.saturating_add(lowest) <= work { passes } else { passes.fewest() }
}

/// The rung of a tick whose patches are pressed, and whether that, or anything before it, is less than the parameters ask for. The highest where there is no budget.
#[inline]
pub(crate) fn rung(
    model: &Model<'_>,
    params: &Params,
    account: &mut Account,
    turns: Option<&Turns>,
    pressed: (&[Patch], Pressed),
) -> (Rung, Flags) {
    match (params.work, turns) {
        (Some(work), Some(turns)) => rung_within(work, model, params, account, turns, pressed),
        _ => {
            if account.wanted.is_some() {
                *account = Account::NEW;
            }
            (params.rung, Flags::CLEAN)
        }
    }
}

#[cold]
#[inline(never)]
fn rung_within(
    work: u32,
    model: &Model<'_>,
    params: &Params,
    account: &mut Account,
    turns: &Turns,
    (patches, pressed): (&[Patch], Pressed),
) -> (Rung, Flags) {
    let wanted = params.rung;
    let contacts = estimate::of_contacts(model, params, &Counts::new(turns, patches, pressed));
    let held = |steps: u8| estimate::of_grip(model, params, wanted.below(steps), patches);
    if account.wanted != Some(wanted) {
        // another ladder: it is begun at its top, and left at once as far as need be
        (account.grip, account.wanted) = (Ladder::TOP, Some(wanted));
    }
    let steps = account.grip.settle(work, wanted.steps_down(), |steps| contacts.saturating_add(held(steps)));
    account.held = held(steps);
    account.work = contacts.saturating_add(account.held);
    account.round = turns.round();
    let lowered = steps > 0 || turns.asked() < ASKED_SAMPLES || turns.waiting() != Parts::NONE || pressed.passes.is_short();
    (wanted.below(steps), if lowered { Flags::TIER_LOWERED } else { Flags::CLEAN })
}

/// Books a tick that is not computed, beside so many patches.
pub(crate) fn book_still(params: &Params, memory: &mut Memory, patches: usize) {
    if params.work.is_some() {
        memory.account.work = estimate::of_still(patches);
    }
}

/// Vertices of the surface that the budget has room for after the last tick: all without a budget.
pub(crate) fn vertices_left(params: &Params, memory: &Memory, patches: usize, body: bool) -> usize {
    params.work.map_or(usize::MAX, |work| estimate::vertices_for(work.saturating_sub(memory.account.work), patches, body))
}
