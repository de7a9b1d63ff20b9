//! The work budget of a tick, and the ladder that keeps to it.
//!
//! **Words.** *Work* is counted in *units*: one is an instruction of the x86-64 release build, so that it is known before a tick what it may cost, whatever the machine
//! and its other work. What a unit takes on a machine, a host measures. An *estimate* is an upper bound from counts (parts near the object, patches, samples,
//! sweeps) times unit costs (`costs.rs`). A *rung* is a setting of tier, samples and sweeps ([`Rung`]); the highest is what the parameters ask for.
//!
//! Where a budget is set, each tick picks its rung once the patches are known and before forces are computed. A rung that does not fit is left **at once**, as many
//! steps down as it takes; a higher one is gone back to **one step** after [`CALM_TICKS`] ticks in a row in which it would have fitted with a margin ([`MARGIN`]). The order in
//! which a tick gives way: first the surface that somebody looks at, which gets what the tick has left ([`deform`](crate::deform)); then the grip's rungs; last, where the
//! lowest rung does not fit beside the search of meshes, the samples which that search asks. Contacts are never left out for work: what is left when all has given way is
//! done, flagged [`TIER_LOWERED`](crate::Flags::TIER_LOWERED), and the report's work says that it is more than the budget.
//!
//! The same budget, poses and settings give the same rungs on every machine, so a recording computed again comes out to the bit. A change of rung carries
//! the force over: what a patch holds is what the other tier, or the other grid, begins with.
//!
//! Degrading by level of detail before a deadline, not after it, is what Barbic and James did for contact of point shells with distance fields (2007, 2008).

mod costs;
mod estimate;
mod rung;

pub use estimate::{of_surface, of_vertex};
pub use rung::Rung;

use crate::frames::{Pose, ProbeFrame, World};
use crate::geometry::support::ASKED_SAMPLES;
use crate::limits::MIN_SAMPLES;
use crate::model::Model;
use crate::params::Params;
use crate::report::Flags;
use crate::state::Memory;
pub(crate) use estimate::Counts;
use rung::MAX_STEPS;

/// Ticks in a row in which the next rung up must fit before it is taken: a tenth of a second at 1 kHz, longer than a contact that chatters.
pub const CALM_TICKS: u8 = 100;

/// Share of the budget, as a divisor, that must stay free on the next rung up: an eighth, so that the next birth beside ten regions does not undo it.
pub const MARGIN: u32 = 8;

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
    /// Estimate of the last tick; 0 without a budget.
    pub work: u32,
}

impl Account {
    /// Without history.
    pub const NEW: Self = Self { grip: Ladder::TOP, search: Ladder::TOP, wanted: None, work: 0 };

    /// The ladders stay where they are while nothing moves.
    pub const fn is_settled(&self) -> bool {
        self.grip.is_settled() && self.search.is_settled()
    }
}

/// Samples that a mesh is asked in this tick: all that are ever asked without a budget, fewer where the search and the lowest rung do not fit together.
#[inline]
pub(crate) fn samples_to_ask(model: &Model<'_>, params: &Params, memory: &mut Memory, x_wp: &Pose<World, ProbeFrame>) -> usize {
    match params.work {
        Some(work) if model.probe.iter().any(estimate::is_mesh) => choose_samples(model, params, memory, work, x_wp),
        _ => ASKED_SAMPLES,
    }
}

fn choose_samples(model: &Model<'_>, params: &Params, memory: &mut Memory, work: u32, x_wp: &Pose<World, ProbeFrame>) -> usize {
    let lowest = params.rung.below(MAX_STEPS);
    let beside = estimate::of_any_tick(model, params).saturating_add(estimate::of_grip(model, params, lowest, model.probe.len()));
    let asked = |steps: u8| ASKED_SAMPLES >> steps;
    let search = &mut memory.account.search;
    asked(search.settle(work.saturating_sub(beside), SEARCH_STEPS, |steps| estimate::of_search(model, x_wp, asked(steps))))
}

/// The rung of a tick without a budget: the highest.
#[inline]
pub(crate) fn unlimited(params: &Params, memory: &mut Memory) -> (Rung, Flags) {
    if memory.account.wanted.is_some() {
        memory.account = Account::NEW;
    }
    (params.rung, Flags::CLEAN)
}

/// The rung of a tick that may spend `work`, and whether that is less than the parameters ask for.
#[cold]
#[inline(never)]
pub(crate) fn choose_within(
    work: u32,
    model: &Model<'_>,
    params: &Params,
    memory: &mut Memory,
    counts: &Counts<'_>,
) -> (Rung, Flags) {
    let (wanted, patches) = (params.rung, counts.patches.len());
    let contacts = estimate::of_contacts(model, params, counts);
    let cost = |steps: u8| contacts.saturating_add(estimate::of_grip(model, params, wanted.below(steps), patches));
    let account = &mut memory.account;
    if account.wanted != Some(wanted) {
        // another ladder: it is begun at its top, and left at once as far as need be
        (account.grip, account.wanted) = (Ladder::TOP, Some(wanted));
    }
    let steps = account.grip.settle(work, wanted.steps_down(), cost);
    account.work = cost(steps);
    let lowered = steps > 0 || counts.asked < ASKED_SAMPLES;
    (wanted.below(steps), if lowered { Flags::TIER_LOWERED } else { Flags::CLEAN })
}

/// Books a tick that is not computed.
pub(crate) fn book_still(params: &Params, memory: &mut Memory) {
    if params.work.is_some() {
        memory.account.work = costs::STILL;
    }
}

/// Vertices of the surface that the budget has room for after the last tick: all without a budget.
pub(crate) fn vertices_left(params: &Params, memory: &Memory, patches: usize, body: bool) -> usize {
    params.work.map_or(usize::MAX, |work| estimate::vertices_for(work.saturating_sub(memory.account.work), patches, body))
}
