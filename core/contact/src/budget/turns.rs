//! Which parts a tick looks at when its work does not suffice for all that are near.
//!
//! The part that has waited longest is looked at first, and one is in every tick; what a look took is booked before the next is begun, and the next must fit if it takes what it took last. So a
//! part waits for as many ticks as there are parts at most, and a tick spends no more than its room and what one look takes beyond the last at the same part.

use super::estimate;
use crate::limits::MAX_PARTS;
use crate::model::{ObjectShape, ProbePart};
use crate::stage::detect::{Look, Parts};

/// What the looks of a tick may take, in units of work.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Without lowering the rung that the grip has.
    pub beside: u32,
    /// With the grip on its lowest rung.
    pub most: u32,
}

/// Share of the near parts, as a divisor, that is looked at before the grip's rung is kept: a quarter, so that none waits longer than a hand's quickest motion of a few milliseconds.
const LEAST_LOOKS: usize = 4;

/// What is remembered of a part from tick to tick.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Ticks for which it has waited.
    pub waited: u8,
    /// What the last look took, `None` where there was none since it came near.
    took: Option<u32>,
}

impl Turn {
    /// Of a part that is far from the object.
    pub const NONE: Self = Self { waited: 0, took: None };
}

/// Of all parts of a probe.
pub type Round = [Turn; MAX_PARTS];

/// The turns of one tick.
#[derive(Clone, Debug)]
pub struct Turns {
    /// Parts whose bounding ball meets the object.
    near: Parts,
    /// Samples that a mesh is asked for.
    asked: usize,
    room: Room,
    round: Round,
    done: Parts,
    looked: Parts,
    spent: u32,
}

impl Turns {
    /// Before the first look.
    pub const fn new(near: Parts, asked: usize, room: Room, round: Round) -> Self {
        Self { near, asked, room, round, done: Parts::NONE, looked: Parts::NONE, spent: 0 }
    }

    /// Parts whose bounding ball meets the object.
    pub const fn near(&self) -> Parts {
        self.near
    }

    /// Samples that a mesh is asked for.
    pub const fn asked(&self) -> usize {
        self.asked
    }

    /// What the looks took, in units of work.
    pub const fn spent(&self) -> u32 {
        self.spent
    }

    /// Near parts that no look was begun at.
    pub const fn waiting(&self) -> Parts {
        self.near.without(self.looked)
    }

    /// The near part that has waited longest of those that have not had their turn, the first of several.
    pub fn next<'p, 'a>(&mut self, probe: &'p [ProbePart<'a>]) -> Option<(usize, &'p ProbePart<'a>)> {
        let age = |index: usize| self.round.get(index).map_or(0, |turn| turn.waited);
        let waiting = self.near.of(probe).filter(|&(index, _)| !self.done.has(index));
        let oldest = waiting.reduce(|best, other| if age(other.0) > age(best.0) { other } else { best })?;
        self.done.add(oldest.0);
        Some(oldest)
    }

    /// Whether another look would fit, at this part.
    pub fn has_room_for(&self, object: &ObjectShape<'_>, index: usize, part: &ProbePart<'_>) -> bool {
        let last = self.round.get(index).and_then(|turn| turn.took);
        let then = self.spent.saturating_add(last.unwrap_or_else(|| estimate::of_first_look(object, part, self.asked)));
        let few = LEAST_LOOKS * self.looked.count() < self.near.count();
        self.looked == Parts::NONE || then <= if few { self.room.most } else { self.room.beside }
    }

    /// Books a look.
    pub fn book(&mut self, object: &ObjectShape<'_>, index: usize, part: &ProbePart<'_>, look: &Look) {
        let took = estimate::of_look(object, part, self.asked, look);
        self.looked.add(index);
        self.spent = self.spent.saturating_add(took);
        if let Some(turn) = self.round.get_mut(index) {
            *turn = Turn { waited: 0, took: Some(took) };
        }
    }

    /// What is remembered when the tick is over: of those that are far from the object nothing.
    pub fn round(&self) -> Round {
        let mut round = self.round;
        for (index, turn) in round.iter_mut().enumerate() {
            if !self.near.has(index) {
                *turn = Turn::NONE;
            } else if !self.looked.has(index) {
                turn.waited = turn.waited.saturating_add(1);
            }
        }
        round
    }
}
