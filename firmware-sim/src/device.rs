//! The whole device as one function of time and bytes.

use glam::{Quat, Vec3};
use haptor_wire::units::{metres_to_nm, un_to_newtons, unit_to_q30, unm_to_newton_metres};
use haptor_wire::{
    DecodeCounts, DeviceFault, FromDevice, Mode, StreamDecoder, ToDevice, encode_stream,
    stream_bound,
};

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
        Self {
            bytes: heapless::Vec::new(),
            dropped: 0,
        }
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
    /// Time since the script began; it waits at its begin until forces are armed [us].
    script_us: u64,
    /// Time passed in for which no tick has been run yet, less than one tick [us].
    rest_us: u32,
}

impl Device {
    /// A device after power-up, its handle at the origin of `d`; `serial` is cut to 12 bytes.
    #[must_use]
    pub fn new(
        preset: &Preset,
        serial: &str,
        hand: Hand,
        encoders: Encoders,
        script: Script,
    ) -> Self {
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

    /// Power off and on: the firmware starts anew, hand and handle are where they were.
    pub fn restart(&mut self, preset: &Preset, serial: &str) {
        self.decoder = StreamDecoder::new();
        self.logic = Logic::new(preset.limits(serial));
        self.outbox = Outbox::default();
    }

    /// The link was opened anew: forgets a frame begun on the old one.
    pub fn link_opened(&mut self) {
        self.decoder.restart();
    }

    /// A push from outside: the handle's velocity changes by this, in `d` [m/s].
    pub fn kick(&mut self, velocity: [f32; 3]) {
        self.plant.velocity += Vec3::from(velocity);
    }

    /// The mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.logic.mode()
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
