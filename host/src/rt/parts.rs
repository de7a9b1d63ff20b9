//! The parts of a tick, in the order in which [`super::control::Control::tick`] calls them.

use haptor_contact::Wrench;
use haptor_wire::device::{DeviceHello, Mode, PoseReport, ToDevice};
use haptor_wire::units::{nm_to_metres, q30_to_unit};
use haptor_wire::{
    FaultRecord, HostFault, PROTOCOL_VERSION, RtReport, SessionHello, TOOL_SCHEMA_HASH, TickRecord, VersionMismatch,
};

use super::budget::OVERRUN_TICKS;
use super::clock::Clock;
use super::control::Control;
use super::desk::Note;
use super::faults::stale_cause;
use super::flags;
use super::handshake::Phase;
use super::line::Arrivals;
use super::pace::{Follow, Slot};
use super::stale::{Offer, SMALL_FORCE, SMALL_TORQUE, Served, StaleRule};
use haptor_engine::{DeviceBase, Felt, command, handle_pose};

/// Time a device has to answer and to reach force mode \[s\]; after it the session ends before it began.
const CONNECT_S: u64 = 3;

/// What a run is told once.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Ticks a second.
    pub rate_hz: u32,
    /// What ticks follow.
    pub follow: Follow,
    /// Ticks of a session; `None` = until it is stopped.
    pub ticks: Option<u64>,
    /// How long a wrench outlives its pose.
    pub stale: StaleRule,
    /// What the real-time policy obtained.
    pub rt: RtReport,
}

impl Settings {
    /// Length of a tick \[ns\].
    #[must_use]
    pub const fn period_ns(&self) -> u64 {
        1_000_000_000 / self.rate_hz as u64
    }

    /// Length of a tick \[us\].
    #[must_use]
    pub const fn period_us(&self) -> u32 {
        1_000_000 / self.rate_hz
    }
}

/// What one tick remembers for the next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memory {
    /// First tick of the session and when it was \[ns\].
    session: Option<(u64, u64)>,
    /// Number of the last command.
    seq: u32,
    /// Number of the last report used.
    echo: u32,
    /// Tick in which the core last ran.
    stepped_at: Option<u64>,
    /// A report since then was no pose.
    refused: bool,
    /// What this tick is recorded as; pose and contact stay from the last tick that had them.
    record: TickRecord,
    /// The device was in a mode for it, and the link took the wrench.
    sent: bool,
    /// The device rendered in the tick before.
    ran: bool,
    /// Ticks in a row that were done in time but for the link, which did not take the wrench.
    untaken: u32,
    /// The device whose limits guard and coupling keep.
    fitted: Option<DeviceHello>,
}

impl<C: Clock> Control<C> {
    /// True when nothing is left to do.
    #[must_use]
    pub fn is_over(&self) -> bool {
        if self.mismatch().is_some() {
            return true;
        }
        match (self.memory.session, self.settings.ticks) {
            (None, _) => self.faults.cause().is_some() && self.pace.tick() > self.connect_ticks(),
            (Some(_), None) => false,
            (Some((first, _)), Some(ticks)) => self.pace.tick() >= first + ticks,
        }
    }

    /// The versions, when the device speaks another.
    #[must_use]
    pub fn mismatch(&self) -> Option<VersionMismatch> {
        match self.handshake.phase() {
            Phase::Refuse(mismatch) => Some(mismatch),
            _ => None,
        }
    }

    fn connect_ticks(&self) -> u64 {
        CONNECT_S * u64::from(self.settings.rate_hz)
    }

    /// Faults of device, link and machine: the output closes before anything else happens.
    pub(super) fn obey(&mut self, got: &Arrivals, slot: &Slot) {
        if let Some(cause) = self.handshake.observe(got, slot.tick) {
            self.trip(cause, 0, slot);
        }
        if self.account.budget().overrun() {
            // a device that takes nothing is not the machine's fault
            let deaf = self.memory.untaken >= OVERRUN_TICKS;
            self.trip(if deaf { HostFault::LinkLost } else { HostFault::Overrun }, 0, slot);
        }
        if self.memory.session.is_none() && slot.tick > self.connect_ticks() {
            let cause = if self.handshake.is_refused() { HostFault::DeviceFault } else { stale_cause(got.nonsense, false) };
            self.trip(cause, 0, slot);
        }
        // a device that renders nothing, for whatever reason, gets its forces back by the small-force rule
        if self.output.is_open() && !self.handshake.is_running() {
            self.output.close();
        }
    }

    /// Closes the output and latches why; `after_ticks` after its first sign. A fault while it is closed says nothing new.
    fn trip(&mut self, cause: HostFault, after_ticks: u32, slot: &Slot) {
        let news = self.output.is_open() || after_ticks > 0 || self.faults.count() == 0;
        self.output.close();
        if news {
            let fault = FaultRecord { cause, tick: self.session_tick(slot), after_ticks };
            self.faults.latch(fault);
            self.account.fault(fault);
            self.desk.tell(Note::Fault(fault));
        }
    }

    /// Whether the device has rendered forces in this run.
    pub(super) const fn has_session(&self) -> bool {
        self.memory.session.is_some()
    }

    /// Number of a tick of the session.
    pub(super) fn session_tick(&self, slot: &Slot) -> u64 {
        self.memory.session.map_or(0, |(first, _)| slot.tick - first)
    }

    /// The first time the device renders, the session begins: guard and coupling learn the device's limits, and the output opens. A device that comes back
    /// as another, or with other limits, is learned anew, from rest, while the output is closed.
    pub(super) fn begin_session(&mut self, slot: &Slot) {
        if !self.handshake.is_running() || self.memory.fitted == self.handshake.device() {
            return;
        }
        let Some(device) = self.handshake.device() else { return };
        self.memory.fitted = Some(device);
        // refused only when the device claims next to no force: then the core's own limits stand and the device clamps
        let _ = self.engine.fit(&device);
        if self.memory.session.is_some() {
            return self.rest();
        }
        self.memory.session = Some((slot.tick, self.clock.now_ns()));
        self.output.open();
        let hello = self.hello(&device);
        let engine = self.engine.get();
        self.account.begin(hello, engine.tuning(), engine.placed());
        self.desk.tell(Note::Device(hello));
    }

    /// The session as others get to know it.
    pub(super) fn hello(&self, device: &DeviceHello) -> SessionHello {
        SessionHello {
            version: PROTOCOL_VERSION,
            schema: TOOL_SCHEMA_HASH,
            period_us: self.settings.period_us(),
            device_name: device.name,
            device_serial: device.serial,
            max_force_un: device.max_force_un,
            max_torque_unm: device.max_torque_unm,
            rt: self.settings.rt,
            work: self.engine.get().tuning().work,
        }
    }

    /// Puts the core at rest, and says so: the next tick is as the first of a session.
    pub(super) fn rest(&mut self) {
        let Some(device) = self.handshake.device() else { return };
        self.engine.rest();
        self.memory.stepped_at = None;
        let hello = self.hello(&device);
        let engine = self.engine.get();
        self.account.rest(hello, engine.tuning(), engine.placed());
    }

    /// The recorder wants ticks that can be computed again. It gets them from the first tick on in which a rest cannot be felt: the core ran, there is no contact,
    /// and next to nothing went out.
    fn rest_if_wanted(&mut self, wrench: &Wrench<DeviceBase>) {
        let Memory { record, .. } = &self.memory;
        let unfelt = record.flags & flags::NO_POSE == 0 && record.regions == 0;
        let small = wrench.force.length() < SMALL_FORCE && wrench.torque.length() < SMALL_TORQUE;
        if unfelt && small && self.account.rest_wanted() {
            self.rest();
        }
    }

    /// Runs the core on a fresh pose. A pose that is none, or that the core refuses, counts as not come.
    pub(super) fn feel(&mut self, got: &Arrivals, slot: &Slot) -> Offer {
        self.memory.record.flags = flags::NO_POSE;
        self.memory.record.step_ns = 0;
        if self.pause.stands() {
            return Offer::Missing;
        }
        let (Some(pose), Some(_)) = (&got.pose, self.memory.session) else { return Offer::Missing };
        self.memory.echo = pose.seq;
        let Some(x_dh) = handle_pose(pose) else { return self.refuse() };
        let since = self.memory.stepped_at.map_or(1, |at| slot.tick - at);
        let dt = (since as f64 / f64::from(self.settings.rate_hz)) as f32;
        let before_ns = self.clock.now_ns();
        let felt = self.engine.step(&x_dh, dt);
        let took_ns = self.clock.now_ns() - before_ns;
        self.memory.note(pose, &felt, took_ns);
        self.memory.stepped_at = Some(slot.tick);
        if felt.non_finite {
            self.trip(HostFault::NonFinite, 0, slot);
        }
        if felt.refused {
            return self.refuse();
        }
        self.memory.refused = false;
        Offer::Fresh { wrench: felt.wrench, small: self.handshake.is_running() && is_small(&felt) }
    }

    fn refuse(&mut self) -> Offer {
        self.memory.refused = true;
        self.memory.record.flags |= flags::POSE_REFUSED;
        Offer::Missing
    }

    /// The wrench to send by the stale rule.
    pub(super) fn choose(&mut self, offer: &Offer, got: &Arrivals, slot: &Slot) -> Wrench<DeviceBase> {
        let (wrench, served) = self.output.serve(offer, slot.slept_through);
        match served {
            Served::Fresh => {}
            Served::Held => self.memory.record.flags |= flags::HELD,
            Served::Closed => self.memory.record.flags |= flags::CLOSED,
            // the core stands because somebody wants it to
            Served::Expired { .. } if self.pause.stands() => self.memory.record.flags |= flags::CLOSED,
            Served::Expired { after_ticks } => {
                self.memory.record.flags |= flags::CLOSED;
                self.trip(stale_cause(got.nonsense, self.memory.refused), after_ticks, slot);
            }
        }
        wrench
    }

    /// Says what the handshake wants said; in a running session, the wrench. A device that has just left it by a fault is told zero: should it still
    /// render, it need not wait for the end of its hold.
    pub(super) fn say(&mut self, wrench: &Wrench<DeviceBase>, slot: &Slot) {
        self.memory.sent = false;
        if let Some(message) = self.handshake.ask(slot.tick) {
            self.line.send(&message);
        } else if self.handshake.is_running() || (self.memory.ran && self.mismatch().is_none()) {
            self.memory.seq = self.memory.seq.wrapping_add(1);
            let command =
                command(self.memory.seq, self.memory.echo, wrench, self.settings.stale.hold * self.settings.period_us());
            let now_ns = self.clock.now_ns();
            self.memory.sent = self.line.send(&ToDevice::Wrench(command));
            if self.memory.sent {
                self.line.trips.sent(command.seq, now_ns);
            }
        }
        self.memory.ran = self.handshake.is_running();
    }

    /// Books the tick, and the fault that latched in it.
    pub(super) fn close(&mut self, wrench: &Wrench<DeviceBase>, slot: &Slot) {
        if let Some((first, start_ns)) = self.memory.session {
            self.book(wrench, slot, first, start_ns);
            self.show(wrench);
            self.rest_if_wanted(wrench);
        }
        self.account.settle();
    }

    fn book(&mut self, wrench: &Wrench<DeviceBase>, slot: &Slot, first: u64, start_ns: u64) {
        let now_ns = self.clock.now_ns();
        let Memory { record, sent, untaken, .. } = &mut self.memory;
        let (punctual, taken) = (now_ns <= slot.deadline_ns, *sent || !self.handshake.is_running());
        *untaken = if punctual && !taken { untaken.saturating_add(1) } else { 0 };
        let in_time = punctual && taken;
        record.tick = slot.tick - first;
        record.t_us = (now_ns - start_ns) / 1000;
        record.force = wrench.force.to_array();
        record.torque = wrench.torque.to_array();
        record.wake_ns = u32::try_from(slot.wake_ns).unwrap_or(u32::MAX);
        record.round_trip_ns = self.line.trips.take_last_ns();
        record.flags |= if in_time { 0 } else { flags::LATE } | if *sent { 0 } else { flags::NOT_SENT };
        let stepped = record.flags & flags::NO_POSE == 0;
        let slept_through = if slot.tick == first { 0 } else { slot.slept_through };
        self.account.tick(record, stepped, slept_through, in_time);
        self.account.progress(record, &self.faults, now_ns);
    }
}

impl<C: Clock> Control<C> {
    /// Leaves the device without force and without a fault: a host that just went silent would trip its watchdog.
    pub(super) fn part(&mut self) {
        if self.mismatch().is_none() {
            self.line.send(&ToDevice::SetMode(Mode::Reset));
        }
    }
}

/// Whether the output may open again. Without contact there is none to be hit by, whatever the probe weighs; but a probe on a virtual coupling may
/// still be swinging, and then the hand would get more than the contact gives.
fn is_small(felt: &Felt) -> bool {
    let length = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>().sqrt();
    let (force, torque) = (length(felt.contact_force), length(felt.contact_torque));
    let at_rest = felt.wrench.force.length() < force + SMALL_FORCE && felt.wrench.torque.length() < torque + SMALL_TORQUE;
    at_rest && (felt.regions == 0 || (force < SMALL_FORCE && torque < SMALL_TORQUE))
}

impl Memory {
    /// Regions in contact when the core last ran.
    pub(super) const fn regions(&self) -> u8 {
        self.record.regions
    }

    /// Position `p_dh` of the handle in the last pose the core took \[m\].
    pub(super) const fn handle(&self) -> [f32; 3] {
        self.record.position
    }

    /// What this tick is recorded as.
    pub(super) const fn record(&self) -> &TickRecord {
        &self.record
    }

    /// Keeps pose and contact for the record.
    fn note(&mut self, pose: &PoseReport, felt: &Felt, took_ns: u64) {
        let record = &mut self.record;
        record.position = pose.position_nm.map(nm_to_metres);
        record.rotation = pose.rotation_q30.map(q30_to_unit);
        record.contact_force = felt.contact_force;
        record.contact_torque = felt.contact_torque;
        record.regions = felt.regions;
        record.depth = felt.depth;
        record.radius = felt.radius;
        record.stick = felt.stick;
        record.tier = felt.tier;
        record.flags = felt.flags;
        record.step_ns = u32::try_from(took_ns).unwrap_or(u32::MAX);
    }
}
