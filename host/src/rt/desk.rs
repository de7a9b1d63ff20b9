//! The desk between the loop and those who look on: what viewers ask, what they are answered, and what ticks looked like.
//!
//! ```text
//!  viewers' thread ──orders──────► loop      one order a tick at most
//!                  ──emergency stop (a flag, ahead of all orders)──►
//!                  ◄──notes──────            answers, what was done, faults
//!                  ◄──looks──────            ticks that somebody wants to see, in boxes that go round
//! ```
//! The memory of all four is there from the start, and nothing here waits or allocates. Nobody looks on: a tick costs a few loads. A look copies what is there,
//! the patches in contact among it; what is computed from that, an ordinary thread computes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use haptor_contact::{MAX_PARTS, Params, Patch, Pose, ProbeFrame, World, Wrench};
use haptor_engine::{Limit, OwnedEngine, Tuned};
use haptor_wire::{Deformation, Denial, Event, FaultRecord, HostFault, Mode, OutputState, SessionHello, TickRecord};
use rtrb::{Consumer, Producer, RingBuffer};

/// Viewers at once: a window, a plot, a recorder, and one more.
pub const VIEWERS_MAX: usize = 4;

/// Orders on their way at once, and so answers that may wait: a person gives one at a time.
pub const ORDERS_MAX: usize = 16;

/// Notes that the viewers' thread may fall behind: the answers, and faults and events beside them.
const NOTES_WAITING: usize = 4 * ORDERS_MAX;

/// Boxes for looks: half a second at 60 a second, longer than an ordinary thread sleeps.
const LOOKS: usize = 32;

/// What a viewer asks the loop to do.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "a box would have to go back to be freed")]
pub enum Order {
    /// Run this engine from now on.
    Activate(Activation),
    /// Take over a tuning.
    Tune {
        /// Number of the scene it was checked for.
        scene: u32,
        /// The tuning.
        tuned: Tuned,
    },
    /// Take over a work budget.
    Limit(Limit),
    /// Let the core stand (true) or go on.
    Freeze(bool),
    /// Place the device so that the probe stands where the scene starts it.
    Tare,
    /// Back from an emergency stop.
    Rearm,
}

/// Another scene.
#[derive(Debug)]
pub struct Activation {
    /// At rest.
    pub engine: OwnedEngine,
    /// Its number, see [`Look::scene`].
    pub scene: u32,
    /// Digest of its file.
    pub digest: u64,
}

/// An order and the number it was given.
#[derive(Debug)]
pub struct Numbered {
    /// The answer carries it.
    pub number: u64,
    /// The order.
    pub order: Order,
}

/// What the loop tells the viewers' thread.
#[derive(Debug)]
pub enum Note {
    /// An order was carried out, or not; an engine that is not needed any more comes back to be dropped.
    Answer {
        /// The order's number.
        number: u64,
        /// Whether it was carried out.
        result: Result<(), Denial>,
        /// The old engine, or the refused one.
        retired: Option<OwnedEngine>,
    },
    /// The emergency stop holds, whether it did before or not.
    Stopped,
    /// The session has begun, or has another work budget.
    Device(SessionHello),
    /// Something was done.
    Event(Event),
    /// A fault has latched.
    Fault(FaultRecord),
}

/// One tick as the loop left it.
#[derive(Debug, Default)]
pub struct Look {
    /// What is recorded of it.
    pub record: TickRecord,
    /// Pose `x_wp` of the probe.
    pub x_wp: Option<Pose<World, ProbeFrame>>,
    /// What was sent.
    pub sent: Option<Wrench<World>>,
    /// The patches in contact, oldest first.
    pub patches: heapless::Vec<Patch, MAX_PARTS>,
    /// The parameters they were computed under.
    pub params: Option<Params>,
    /// How much of the surface's deformation the tuning shows.
    pub deformation: Option<Deformation>,
    /// What a tick may spend \[instructions\].
    pub work: Option<u32>,
    /// Number of the scene: 0 is the first, and each activation has its own.
    pub scene: u32,
    /// Share of ticks in time so far \[1/1000\].
    pub in_time_permille: u16,
    /// The device's mode.
    pub mode: Mode,
    /// What the output does.
    pub output: OutputState,
    /// The latched fault.
    pub fault: Option<HostFault>,
    /// Poses lost, frames rejected, poses out of order, records dropped so far.
    pub counts: [u64; 4],
}

/// What viewers want, as the loop reads it.
#[derive(Debug, Default)]
pub struct Wanted {
    /// For each viewer: a look every so many ticks; 0 = none.
    every: [AtomicU32; VIEWERS_MAX],
    /// Somebody hit the emergency stop.
    stop: AtomicBool,
    /// Looks that found no box.
    missed: AtomicU64,
}

impl Wanted {
    /// A viewer wants a look every so many ticks.
    pub fn look_every(&self, viewer: usize, every: u32) {
        if let Some(slot) = self.every.get(viewer) {
            slot.store(every, Ordering::Relaxed);
        }
    }

    /// The emergency stop.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Looks left out because all boxes were on their way.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }

    /// Whether somebody wants to see a tick, given the one before.
    fn is_wanted(&self, tick: u64, before: Option<u64>) -> bool {
        self.every.iter().any(|every| is_due(tick, before, every.load(Ordering::Relaxed)))
    }
}

/// Whether a tick is the first since `before` whose number has reached a multiple of `every`; never when that is 0.
#[must_use]
pub fn is_due(tick: u64, before: Option<u64>, every: u32) -> bool {
    every > 0 && before.is_none_or(|before| tick / u64::from(every) != before / u64::from(every))
}

/// The loop's side.
#[derive(Debug)]
pub struct Desk {
    wanted: Arc<Wanted>,
    orders: Consumer<Numbered>,
    notes: Producer<Note>,
    looks: Producer<Box<Look>>,
    spare: Consumer<Box<Look>>,
    /// The last tick that was asked about.
    last: Option<u64>,
}

/// The viewers' thread's side.
#[derive(Debug)]
pub struct Counter {
    /// What viewers want.
    pub wanted: Arc<Wanted>,
    /// Orders; no more than [`ORDERS_MAX`] unanswered.
    pub orders: Producer<Numbered>,
    /// Answers and news.
    pub notes: Consumer<Note>,
    /// Ticks.
    pub looks: Consumer<Box<Look>>,
    /// Boxes that have been looked at.
    pub spare: Producer<Box<Look>>,
}

/// Both sides, with all their memory.
#[must_use]
pub fn desk() -> (Desk, Counter) {
    desk_with(LOOKS)
}

/// A desk that nobody comes to.
#[must_use]
pub fn closed_desk() -> Desk {
    desk_with(0).0
}

fn desk_with(boxes: usize) -> (Desk, Counter) {
    let wanted = Arc::new(Wanted::default());
    let (given, orders) = RingBuffer::new(ORDERS_MAX);
    let (notes, told) = RingBuffer::new(NOTES_WAITING);
    let (looks, seen) = RingBuffer::new(boxes);
    let (mut returned, spare) = RingBuffer::new(boxes);
    for _ in 0..boxes {
        // as many places as boxes: there is room
        let _ = returned.push(Box::default());
    }
    let desk = Desk { wanted: Arc::clone(&wanted), orders, notes, looks, spare, last: None };
    (desk, Counter { wanted, orders: given, notes: told, looks: seen, spare: returned })
}

impl Desk {
    /// Whether the emergency stop was hit since this was last asked.
    pub fn take_stop(&self) -> bool {
        // a load is cheaper than a swap, and the flag is as good as never set
        self.wanted.stop.load(Ordering::Relaxed) && self.wanted.stop.swap(false, Ordering::Relaxed)
    }

    /// The next order, if any.
    pub fn next_order(&mut self) -> Option<Numbered> {
        self.orders.pop().ok()
    }

    /// Tells the viewers' thread.
    ///
    /// Answers find room: no more orders than that are on their way. News leave room for them, and for word of an emergency stop; news that find none are old
    /// news to a reader that slow.
    pub fn tell(&mut self, note: Note) {
        let kept_free = match &note {
            Note::Answer { .. } => 0,
            Note::Stopped => ORDERS_MAX,
            Note::Device(_) | Note::Event(_) | Note::Fault(_) => 2 * ORDERS_MAX,
        };
        if self.notes.slots() > kept_free {
            let _ = self.notes.push(note);
        }
    }

    /// A box to show a tick in, when somebody wants to see it.
    pub fn look(&mut self, tick: u64) -> Option<Box<Look>> {
        let before = self.last.replace(tick);
        if !self.wanted.is_wanted(tick, before) {
            return None;
        }
        let look = self.spare.pop().ok();
        if look.is_none() {
            self.wanted.missed.fetch_add(1, Ordering::Relaxed);
        }
        look
    }

    /// Hands a filled box over.
    pub fn show(&mut self, look: Box<Look>) {
        // as many places as boxes: there is room
        let _ = self.looks.push(look);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_due_once_a_multiple_whatever_was_slept_through() {
        let due = |ticks: &[u64], every| {
            let mut before = None;
            let mut due = Vec::new();
            for &tick in ticks {
                if is_due(tick, before.replace(tick), every) {
                    due.push(tick);
                }
            }
            due
        };
        assert_eq!(due(&[0, 1, 2, 3, 4, 5, 6], 3), [0, 3, 6]);
        assert_eq!(due(&[1, 2, 7, 8, 9, 10, 30], 5), [1, 7, 10, 30]);
        assert_eq!(due(&[0, 1, 2], 1), [0, 1, 2]);
        assert!(due(&[0, 1, 2], 0).is_empty());
    }

    #[test]
    fn boxes_go_round_and_what_finds_none_is_counted() {
        let (mut desk, mut counter) = desk();
        assert!(desk.look(0).is_none(), "nobody looks");
        counter.wanted.look_every(VIEWERS_MAX - 1, 2);
        for tick in 1..=2 * (LOOKS as u64 + 1) {
            if let Some(look) = desk.look(tick) {
                desk.show(look);
            }
        }
        assert_eq!(counter.wanted.missed(), 1);
        let look = counter.looks.pop().unwrap();
        counter.spare.push(look).unwrap();
        assert!(desk.look(1000).is_some());
        counter.wanted.look_every(VIEWERS_MAX, 1);
    }

    #[test]
    fn a_closed_desk_takes_and_shows_nothing() {
        let mut desk = closed_desk();
        assert!(desk.next_order().is_none() && desk.look(0).is_none() && !desk.take_stop());
        desk.tell(Note::Event(Event { tick: 0, what: haptor_wire::What::Mark }));
    }

    #[test]
    fn news_leave_room_for_every_answer() {
        let (mut desk, counter) = desk();
        (0..1000).for_each(|tick| desk.tell(Note::Event(Event { tick, what: haptor_wire::What::Mark })));
        desk.tell(Note::Stopped);
        for number in 0..ORDERS_MAX as u64 {
            desk.tell(Note::Answer { number, result: Ok(()), retired: None });
        }
        assert_eq!(counter.notes.slots(), NOTES_WAITING + 1 - ORDERS_MAX, "news, a stop, every answer");
    }
}
