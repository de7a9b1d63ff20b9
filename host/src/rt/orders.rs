//! What viewers ask, carried out between two ticks, at most one thing a tick; and what they are shown of a tick.
//!
//! A new scene, a new place of the device, or a core that goes on after it stood would put a step into the wrench. So these **wait**: the core stands, the wrench
//! fades to zero by the stale rule ([`super::stale`]), the output closes, and only then is the order carried out. Forces come back by the small-force rule.
//! An emergency stop waits for nothing: the output closes in the same tick and the device is told to brake. Ticks in which the core stands are recorded as such in which no
//! pose came, and whatever the core is changed by is recorded where it happens, so that a recording is computed again with the same bits.

use haptor_contact::{Vec3, Wrench};
use haptor_engine::{DeviceBase, OwnedEngine, Placed};
use haptor_wire::{Denial, Event, OutputState, PROTOCOL_VERSION, Place, Record, RecordHeader, TOOL_SCHEMA_HASH, What};

use super::clock::Clock;
use super::control::Control;
use super::desk::{Activation, Note, Numbered, Order};
use super::pace::Slot;

/// Why the core stands.
#[derive(Debug, Default)]
pub struct Pause {
    /// Somebody froze it.
    frozen: bool,
    /// An order waits for the output to close.
    waiting: Option<Numbered>,
    /// Number of the scene that runs.
    scene: u32,
}

impl Pause {
    /// Whether the core stands.
    pub const fn stands(&self) -> bool {
        self.frozen || self.waiting.is_some()
    }
}

/// Whether an order was carried out, and an engine that goes back.
type Carried = (Result<(), Denial>, Option<OwnedEngine>);

impl<C: Clock> Control<C> {
    /// Looks for the emergency stop, and for one order.
    pub(super) fn attend(&mut self, slot: &Slot) {
        if self.desk.take_stop() {
            self.emergency_stop(slot);
        }
        if self.pause.waiting.is_none()
            && let Some(next) = self.desk.next_order()
        {
            self.receive(next, slot);
        }
        if !self.output.is_open()
            && let Some(Numbered { number, order }) = self.pause.waiting.take()
        {
            let carried = self.carry_out(order, slot);
            self.answer(number, carried);
        }
    }

    fn emergency_stop(&mut self, slot: &Slot) {
        if !self.handshake.is_stopped() {
            self.output.close();
            self.handshake.stop();
            self.happened(What::EmergencyStop, slot);
        }
        self.desk.tell(Note::Stopped);
    }

    /// Carries an order out at once, or lets it wait for the output to close.
    fn receive(&mut self, next: Numbered, slot: &Slot) {
        let touching = self.memory.regions() > 0;
        let refused = match &next.order {
            // whatever runs, and before anything does
            Order::Limit(_) => None,
            _ if !self.has_session() => Some(Denial::NoSession),
            Order::Tare if self.pause.frozen => Some(Denial::Frozen),
            Order::Tare if touching => Some(Denial::InContact),
            Order::Rearm if !self.handshake.is_stopped() => Some(Denial::NotStopped),
            Order::Tune { scene, .. } if *scene != self.pause.scene => Some(Denial::Busy),
            _ => None,
        };
        let Numbered { number, order } = next;
        match (refused, order) {
            (Some(why), Order::Activate(activation)) => self.answer(number, (Err(why), Some(activation.engine))),
            (Some(why), _) => self.answer(number, (Err(why), None)),
            // a core that runs needs not stand to go on
            (None, Order::Freeze(false)) if !self.pause.frozen => self.answer(number, (Ok(()), None)),
            (None, order @ (Order::Activate(_) | Order::Tare | Order::Freeze(false))) => {
                self.pause.waiting = Some(Numbered { number, order });
            }
            (None, order) => {
                let carried = self.carry_out(order, slot);
                self.answer(number, carried);
            }
        }
    }

    fn answer(&mut self, number: u64, (result, retired): Carried) {
        self.desk.tell(Note::Answer { number, result, retired });
    }

    fn carry_out(&mut self, order: Order, slot: &Slot) -> Carried {
        match order {
            Order::Activate(activation) => return self.activate(activation),
            Order::Tune { tuned, .. } => {
                self.engine.tune(&tuned);
                self.tuned();
            }
            Order::Limit(limit) => {
                self.engine.limit(limit);
                self.tuned();
            }
            Order::Freeze(true) => {
                self.pause.frozen = true;
                self.happened(What::Frozen, slot);
            }
            Order::Freeze(false) => self.resume(slot),
            Order::Tare => return (self.tare(slot), None),
            Order::Rearm => {
                self.handshake.rearm(slot.tick);
                self.happened(What::Rearmed, slot);
            }
        }
        (Ok(()), None)
    }

    /// Records what holds now, and says what a tick may spend. Before the session begins nobody computes anything again, and its begin says it all.
    fn tuned(&mut self) {
        if !self.has_session() {
            return;
        }
        self.account.keep(Record::Tuning(*self.engine.get().tuning()));
        // a device that is gone is asked anew when it is back
        if let Some(device) = self.handshake.device() {
            self.desk.tell(Note::Device(self.hello(&device)));
        }
    }

    /// The core goes on as if it began: what the hand did meanwhile it has not seen.
    fn resume(&mut self, slot: &Slot) {
        if std::mem::take(&mut self.pause.frozen) {
            self.happened(What::Resumed, slot);
            self.rest();
        }
    }

    fn activate(&mut self, activation: Activation) -> Carried {
        let Activation { mut engine, scene, digest } = activation;
        let Some(device) = self.handshake.device() else { return (Err(Denial::NoSession), Some(engine)) };
        // refused only when the device claims next to no force, as at the session's begin
        let _ = engine.fit(&device);
        let old = std::mem::replace(&mut self.engine, engine);
        self.pause.scene = scene;
        // the recorder, which has the file, writes the rest of it
        self.account.keep(Record::Header(RecordHeader {
            version: PROTOCOL_VERSION,
            schema: TOOL_SCHEMA_HASH,
            rate_hz: self.settings.rate_hz,
            scene_digest: digest,
            start_unix_s: 0,
            schema_bytes: 0,
            scene_bytes: 0,
        }));
        self.rest();
        self.desk.tell(Note::Device(self.hello(&device)));
        (Ok(()), Some(old))
    }

    /// Places the device so that the probe, turned as it is, stands where the scene starts it: position only, or the hand's tilt would tilt the world.
    fn tare(&mut self, slot: &Slot) -> Result<(), Denial> {
        let engine = self.engine.get();
        let now = *engine.placed();
        let moved = engine.in_world(&Wrench::new(Vec3::from_array(self.memory.handle()), Vec3::ZERO)).force;
        let p_wd = Vec3::from_array(engine.start().p_wd) - moved;
        // a pose that the core took is finite
        let placed = Placed::new(&Place { p_wd: p_wd.to_array(), ..now }).map_err(|_| Denial::Value)?;
        self.engine.place(&placed);
        self.happened(What::Tared, slot);
        self.rest();
        Ok(())
    }

    fn happened(&mut self, what: What, slot: &Slot) {
        let event = Event { tick: self.session_tick(slot), what };
        self.account.keep(Record::Event(event));
        self.desk.tell(Note::Event(event));
    }

    /// Shows the tick to those who want to see it.
    pub(super) fn show(&mut self, wrench: &Wrench<DeviceBase>) {
        let record = self.memory.record();
        let Some(mut look) = self.desk.look(record.tick) else { return };
        let engine = self.engine.get();
        look.record = *record;
        look.x_wp = engine.probe_pose();
        look.sent = Some(engine.in_world(wrench));
        look.patches.clear();
        // as much room as a probe has parts
        let _ = look.patches.extend_from_slice(engine.patches());
        look.params = Some(*engine.params());
        look.deformation = Some(engine.tuning().deformation);
        look.work = engine.tuning().work;
        look.scene = self.pause.scene;
        look.in_time_permille = (self.account.budget().share() * 1000.0) as u16;
        look.mode = self.handshake.mode();
        look.output = self.output_state();
        look.fault = self.faults.cause();
        let counts = self.line.counts();
        look.counts = [counts.lost, self.line.rejected(), counts.out_of_order, self.account.dropped()];
        self.desk.show(look);
    }

    fn output_state(&self) -> OutputState {
        match self.output.is_open() {
            _ if self.handshake.is_stopped() => OutputState::Stopped,
            _ if self.pause.frozen => OutputState::Frozen,
            true => OutputState::Open,
            false => OutputState::Closed,
        }
    }
}
