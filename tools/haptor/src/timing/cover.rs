//! Which conditions the measured ticks were in: what was exercised is said, and so is what was not.

use haptor_contact::{Flags, MAX_REGIONS};
use haptor_engine::Engine;
use haptor_wire::TickRecord;

use super::level::has_cells;

/// Conditions beside the core's flags, in the order of [`Cover::conditions`].
const CONDITIONS: [&str; 12] = [
    "region born",
    "region left",
    "patches merged into a region",
    "one region gives way to another",
    "sticks all over",
    "sticks and slips",
    "slips all over",
    CELLS_FITTED,
    "tier changed",
    "pose that is none",
    "a cheaper tier for want of work",
    "virtual coupling",
];

/// A patch as the next tick is compared with it: serial number, width of its cells.
type Known = (u32, f32);

/// Ticks by condition.
#[derive(Clone, Debug, Default)]
pub struct Cover {
    ticks: u64,
    regions: [u64; MAX_REGIONS + 1],
    flags: [u64; Flags::NAMES.len()],
    conditions: [u64; CONDITIONS.len()],
    /// In tiers with cells.
    with_cells: u64,
    known: Vec<Known>,
    tier: Option<haptor_wire::Tier>,
}

fn has(tick: &TickRecord, flag: Flags) -> bool {
    Flags(tick.flags).contains(flag)
}

/// What only tiers with cells do.
const CELLS_FITTED: &str = "cells fitted anew";

/// Conditions that need two patches.
const OF_TWO: [&str; 4] = ["patches merged into a region", "one region gives way to another", "region refused", "birth waits"];

/// Why a condition was not met.
fn why_not(condition: &str, parts: usize, has_cells: bool) -> &'static str {
    match condition {
        CELLS_FITTED if !has_cells => "cannot be: no tier that was measured has cells",
        "non-finite" => "the core never let one happen; a tick in it would be a defect",
        _ if parts < 2 && OF_TWO.contains(&condition) => "cannot be: the probe has one part, which makes one patch",
        "length floored" => {
            "only tier paper has that length, and its floor is met where a twisted contact faces away from the base's centre"
        }
        _ => "no motion and no search came to it",
    }
}

impl Cover {
    /// A history begins.
    pub fn rest(&mut self) {
        self.known.clear();
        self.tier = None;
    }

    /// A tick, and the engine behind it.
    pub fn tick(&mut self, tick: &TickRecord, engine: &Engine<'_>) {
        self.ticks += 1;
        self.with_cells += u64::from(has_cells(tick.tier));
        self.regions[usize::from(tick.regions).min(MAX_REGIONS)] += 1;
        for (bit, count) in self.flags.iter_mut().enumerate() {
            *count += u64::from(tick.flags >> bit & 1);
        }
        let patches = engine.patches();
        let now: Vec<Known> = patches.iter().map(|patch| (patch.born, patch.cells.width)).collect();
        let same = |list: &[Known], one: &Known| list.iter().find(|other| other.0 == one.0).copied();
        let refitted = |one: &Known| same(&self.known, one).is_some_and(|before| before.1 != one.1);
        let touching = !patches.is_empty();
        let met = [
            now.iter().any(|one| same(&self.known, one).is_none()),
            self.known.iter().any(|one| same(&now, one).is_none()),
            patches.len() > usize::from(tick.regions),
            patches.iter().any(|patch| patch.share < 1.0),
            touching && patches.iter().all(|patch| patch.grip.stick >= 1.0),
            patches.iter().any(|patch| patch.grip.stick > 0.0 && patch.grip.stick < 1.0),
            touching && patches.iter().all(|patch| patch.grip.stick <= 0.0),
            has_cells(tick.tier) && now.iter().any(refitted),
            self.tier.is_some_and(|tier| tier != tick.tier),
            has(tick, Flags::POSE_REFUSED) && !has(tick, Flags::POSE_JUMP),
            has(tick, Flags::TIER_LOWERED) && engine.tuning().tier != tick.tier,
            engine.is_coupled(),
        ];
        for (count, met) in self.conditions.iter_mut().zip(met) {
            *count += u64::from(met);
        }
        (self.known, self.tier) = (now, Some(tick.tier));
    }

    /// Takes over what another has counted.
    pub fn add(&mut self, other: &Self) {
        self.ticks += other.ticks;
        self.with_cells += other.with_cells;
        let pairs = [
            (&mut self.regions[..], &other.regions[..]),
            (&mut self.flags[..], &other.flags[..]),
            (&mut self.conditions[..], &other.conditions[..]),
        ];
        for (into, from) in pairs {
            into.iter_mut().zip(from).for_each(|(into, from)| *into += from);
        }
    }

    /// Conditions that no tick was in, each with why it cannot be met, where it cannot; `parts` = parts of the probe.
    pub fn unmet(&self, parts: usize) -> impl Iterator<Item = (&'static str, &'static str)> {
        let unmet = self.conditions().filter(|(_, ticks)| *ticks == 0);
        unmet.map(move |(name, _)| (name, why_not(name, parts, self.with_cells > 0)))
    }

    /// Ticks seen.
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Ticks with each number of regions, from 0.
    pub const fn regions(&self) -> &[u64] {
        &self.regions
    }

    /// Every condition with the ticks that were in it: those of the contact, then the core's flags.
    pub fn conditions(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let own = CONDITIONS.into_iter().zip(self.conditions);
        own.chain(Flags::NAMES.into_iter().zip(self.flags))
    }
}
