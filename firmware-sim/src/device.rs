//! The whole device as one function of time and bytes.

use glam::{Quat, Vec3};
use haptor_wire::units::{metres_to_nm, un_to_newtons, unit_to_q30, unm_to_newton_metres};
use haptor_wire::{DecodeCounts, DeviceFault, FromDevice, Mode, StreamDecoder, ToDevice, encode_stream, stream_bound};

use crate::logic::{Logic, Outbox, Rendered, Sensed, TICK_US};
use crate::plant::{Encoders, Hand, Load, Plant};
use crate::preset::{Preset, micro};
use crate::script::Script;

/// Bytes of a host's frame at most, its final zero not counted.
const RX_FRAME: usize = stream_bound(ToDevice::MAX_ENCODED) - 1;

/// Bytes of a device's frame at most.
const TX_FRAME: usize = stream_bound(FromDevice::MAX_ENCODED);

/// Bytes that a [`TxBuf`] holds: a hundred reports, what a device has to say in 100 ms at 1 kHz.
pub const TX_BYTES: usize = 100 * TX_FRAME;

/// Bytes to send. What does not fit is dropped frame by frame, and counted.
#[derive(Clone, Debug, Default)]
pub struct TxBuf {
    bytes: heapless::Vec<u8, TX_BYTES>,
    dropped: u32,
}

impl TxBuf {
    /// An empty buffer.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: heapless::Vec::new(), dropped: 0 }
    }

    /// The bytes, in order; whole frames.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        &self.bytes
    }

    /// Empties it.
    pub fn clear(&mut self) {
        self.bytes.clear();
    }

    /// Frames that did not fit, since the start.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }

    fn send(&mut self, message: &FromDevice) {
        let mut frame = [0; TX_FRAME];
        let sent = encode_stream(message, &mut frame)
            .ok()
            .and_then(|n| frame.get(..n))
            .and_then(|frame| self.bytes.extend_from_slice(frame).ok());
        if sent.is_none() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }
}

/// A simulated device.
#[derive(Clone, Debug)]
pub struct Device {
    decoder: StreamDecoder<RX_FRAME>,
    logic: Logic,
    outbox: Outbox,
    plant: Plant,
    encoders: Encoders,
    script: Script,
    /// Time since the script began; it waits at its begin until forces are armed \[us\].
    script_us: u64,
    /// Time passed in for which no tick has been run yet, less than one tick \[us\].
    rest_us: u32,
}

impl Device {
    /// A device after power-up, its handle at the origin of `d`; `serial` is cut to 12 bytes.
    #[must_use]
    pub fn new(preset: &Preset, serial: &str, hand: Hand, encoders: Encoders, script: Script) -> Self {
        Self {
            decoder: StreamDecoder::new(),
            logic: Logic::new(preset.limits(serial)),
            outbox: Outbox::default(),
            plant: Plant::new(preset, hand),
            encoders,
            script,
            script_us: 0,
            rest_us: 0,
        }
    }

    /// Takes the bytes that came, lets `dt_us` pass, and appends what it has to say to `tx`.
    ///
    /// The bytes count as having come at the begin of `dt_us`. Time goes on in whole ticks; what is left over is kept.
    pub fn step(&mut self, dt_us: u32, rx: &[u8], tx: &mut TxBuf) {
        let (logic, outbox) = (&mut self.logic, &mut self.outbox);
        self.decoder.feed(rx, |message: ToDevice| {
            logic.receive(message, outbox);
            outbox.take().for_each(|answer| tx.send(&answer));
        });
        let time = u64::from(self.rest_us) + u64::from(dt_us);
        for _ in 0..time / u64::from(TICK_US) {
            self.tick();
            self.outbox.take().for_each(|message| tx.send(&message));
        }
        self.rest_us = (time % u64::from(TICK_US)) as u32;
    }

    /// Power off and on: the firmware starts anew, hand and handle are where they were, [`Self::counts`] goes on.
    pub fn restart(&mut self, preset: &Preset, serial: &str) {
        self.decoder.restart();
        self.logic = Logic::new(preset.limits(serial));
        self.outbox = Outbox::default();
    }

    /// The link was opened anew: forgets a frame begun on the old one.
    pub fn link_opened(&mut self) {
        self.decoder.restart();
    }

    /// A push from outside: the handle's velocity changes by this, in `d` \[m/s\].
    pub fn kick(&mut self, velocity: [f32; 3]) {
        self.plant.velocity += Vec3::from(velocity);
    }

    /// The mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.logic.mode()
    }

    /// Time between two reports, as the host asked for \[us\].
    #[must_use]
    pub const fn period_us(&self) -> u32 {
        self.logic.period_us()
    }

    /// The latched fault.
    #[must_use]
    pub const fn fault(&self) -> Option<DeviceFault> {
        self.logic.fault()
    }

    /// What came over the link.
    #[must_use]
    pub const fn counts(&self) -> DecodeCounts {
        self.decoder.counts()
    }

    /// Whether a frame has begun to come and not ended.
    #[must_use]
    pub fn is_amid_a_frame(&self) -> bool {
        self.decoder.pending() > 0
    }

    /// Hand and handle.
    #[must_use]
    pub const fn plant(&self) -> &Plant {
        &self.plant
    }

    fn tick(&mut self) {
        let sensed = self.sense();
        let rendered = self.logic.tick(&sensed, &mut self.outbox);
        let target = self.script.target(self.script_us);
        self.plant.step(&target, &load(&rendered));
        self.advance_script();
    }

    fn sense(&self) -> Sensed {
        let (position, q) = self.encoders.read(self.plant.position, self.plant.rotation);
        Sensed {
            position_nm: position.to_array().map(metres_to_nm),
            rotation_q30: wxyz(q).map(unit_to_q30),
            buttons: 0,
            speed_um_s: micro(self.plant.velocity.length()),
            spin_urad_s: micro(self.plant.spin.length()),
        }
    }

    /// The script begins when forces are armed; once begun it runs to its end, armed or not, and there waits again.
    fn advance_script(&mut self) {
        let begun = self.script_us > 0;
        if !begun && self.logic.mode() != Mode::Force {
            return;
        }
        self.script_us += u64::from(TICK_US);
        if self.script.repeats() && self.script_us >= self.script.length_us() {
            self.script_us = 0;
        }
    }
}

fn wxyz(q: Quat) -> [f32; 4] {
    [q.w, q.x, q.y, q.z]
}

fn load(rendered: &Rendered) -> Load {
    Load {
        force: Vec3::from(rendered.force_un.map(un_to_newtons)),
        torque: Vec3::from(rendered.torque_unm.map(unm_to_newton_metres)),
        braked: rendered.braked,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::FIRM_GRIP;
    use crate::preset::PREMIUM15;
    use crate::script::Reach;
    use haptor_wire::{HostHello, PROTOCOL_VERSION, SCHEMA_HASH};
    use std::vec::Vec;

    fn device() -> Device {
        let reach = Reach::usual(FIRM_GRIP.stiffness, PREMIUM15.max_force);
        let script = Script::by_name("press", &reach, true).unwrap();
        Device::new(&PREMIUM15, "T", FIRM_GRIP, Encoders::FINE, script)
    }

    fn frame(message: &ToDevice) -> Vec<u8> {
        let mut out = [0; 64];
        let n = encode_stream(message, &mut out).unwrap();
        out[..n].to_vec()
    }

    fn opening() -> Vec<u8> {
        let hello = ToDevice::Hello(HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 });
        [frame(&hello), frame(&ToDevice::SetMode(Mode::Force))].concat()
    }

    fn said(tx: &TxBuf) -> Vec<FromDevice> {
        let mut messages = Vec::new();
        let mut decoder = StreamDecoder::<64>::new();
        decoder.feed(tx.as_slice(), |message| messages.push(message));
        messages
    }

    #[test]
    fn the_same_calls_give_the_same_bytes_however_time_is_cut() {
        let run = |cuts: &[u32]| {
            let (mut device, mut all) = (device(), Vec::new());
            let mut tx = TxBuf::new();
            device.step(0, &opening(), &mut tx);
            for dt in cuts.iter().cycle().scan(0, |t, &dt| {
                *t += dt;
                (*t <= 200_000).then_some(dt)
            }) {
                device.step(dt, &[], &mut tx);
                all.extend_from_slice(tx.as_slice());
                tx.clear();
            }
            all
        };
        let whole = run(&[1000]);
        assert!(whole.len() > 200 * 15, "{}", whole.len());
        for cuts in [&[125][..], &[1], &[250, 750], &[100, 900, 1000], &[10_000]] {
            assert_eq!(run(cuts), whole, "{cuts:?}");
        }
    }

    #[test]
    fn the_hand_waits_until_forces_are_armed() {
        let (mut device, mut tx) = (device(), TxBuf::new());
        device.step(2_000_000, &[], &mut tx);
        assert_eq!(device.plant().position, Vec3::ZERO);
        device.step(25_000, &opening(), &mut tx);
        assert_eq!(device.mode(), Mode::Force);
        device.step(300_000, &[], &mut tx);
        assert_eq!(device.mode(), Mode::Brake, "nobody answered");
        assert!(device.plant().position.z < -1e-3);
    }

    #[test]
    fn a_kick_trips_over_speed_and_a_restart_forgets_it() {
        let (mut device, mut tx) = (device(), TxBuf::new());
        device.step(1000, &opening(), &mut tx);
        device.kick([0.0, 2.0, 0.0]);
        device.step(1000, &[], &mut tx);
        assert_eq!(device.mode(), Mode::Brake);
        let fault = device.fault().unwrap();
        assert!(said(&tx).contains(&FromDevice::Fault(fault)));
        device.restart(&PREMIUM15, "T");
        assert_eq!((device.mode(), device.fault()), (Mode::Reset, None));
    }

    #[test]
    fn a_tx_buffer_nobody_empties_holds_whole_frames_and_counts_the_rest() {
        let (mut device, mut tx) = (device(), TxBuf::new());
        device.step(0, &opening(), &mut tx);
        for _ in 0..500 {
            device.step(1000, &[], &mut tx);
        }
        let kept = said(&tx).len() as u32;
        // a hello, a fault, 500 reports
        assert_eq!(kept + tx.dropped(), 502);
        assert!(kept >= 100);
        assert_eq!(tx.as_slice().last(), Some(&0));
    }

    #[test]
    fn garbage_is_counted_and_changes_nothing() {
        let (mut device, mut tx) = (device(), TxBuf::new());
        let garbage: Vec<u8> = (0..4000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).chain([0]).collect();
        device.step(0, &garbage, &mut tx);
        assert_eq!(device.mode(), Mode::Reset);
        assert!(device.counts().rejected() > 5);
        device.step(1000, &opening(), &mut tx);
        assert_eq!(device.mode(), Mode::Force);
    }
}
