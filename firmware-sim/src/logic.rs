//! What the firmware decides: modes, watchdog, limits, refusals, reports.
//!
//! Integers only, no device under it: messages and sensed values come in, messages and a wrench to render go out. The rules are
//! those of `core/wire/WIRE.md`; real firmware can be held against this file. Time passes in ticks of [`TICK_US`].
//!
//! ```text
//!            hello, tables agree          set Force
//!   Reset ────────────────────────► Idle ───────────► Force
//!     ▲ ▲                            │ ▲ ◄───────────   │
//!     │ └──── no host for 1 s ───────┘      set Idle     │ fault, or set Brake
//!     └──────────── set Reset ─────── Brake ◄────────────┘
//! ```

use haptor_wire::device::WATCHDOG_STEP_US;
use haptor_wire::units::NOT_A_NUMBER;
use haptor_wire::{
    DeviceFault, DeviceHello, FaultCause, FromDevice, HostHello, Mode, PROTOCOL_VERSION, PoseReport, SCHEMA_HASH, ToDevice,
    WrenchCommand, check_device_version,
};

use crate::limits::{scale, shorten};

/// Time of one tick \[us\].
pub const TICK_US: u32 = WATCHDOG_STEP_US;

/// Period of reports while the host has not asked for another \[us\].
pub const DEFAULT_PERIOD_US: u32 = 1_000;

/// Longest period of reports \[us\]: slower than this no loop is closed, so it is a mistake.
pub const LONGEST_PERIOD_US: u32 = 100_000;

/// How long a wrench fades after its hold \[ticks\]: 10 ms, short against a hand's reaction, long against a click.
pub const FADE_TICKS: u32 = 80;

/// Silence of the host after which a session without forces ends \[ticks\]: 1 s.
pub const SESSION_TICKS: u32 = 8_000;

/// What a device is, and where its limits lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Model, ASCII, padded with zeros.
    pub name: [u8; 12],
    /// Serial number, ASCII, padded with zeros.
    pub serial: [u8; 12],
    /// Largest force \[uN\].
    pub max_force_un: u32,
    /// Largest torque \[uN m\]; 0 = none can be rendered.
    pub max_torque_unm: u32,
    /// Ticks without an accepted wrench in [`Mode::Force`] until the brake.
    pub watchdog_ticks: u16,
    /// Speed in [`Mode::Force`] above which it brakes \[um/s\].
    pub over_speed_um_s: u32,
    /// Angular speed in [`Mode::Force`] above which it brakes \[urad/s\].
    pub over_spin_urad_s: u32,
}

/// What the sensors say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sensed {
    /// Position `p_dh` \[nm\].
    pub position_nm: [i32; 3],
    /// Rotation `q_dh`, unit quaternion (w, x, y, z) \[2^-30\].
    pub rotation_q30: [i32; 4],
    /// Bit k set = button k held.
    pub buttons: u8,
    /// Speed of the handle's origin \[um/s\].
    pub speed_um_s: u32,
    /// Angular speed of the handle \[urad/s\].
    pub spin_urad_s: u32,
}

/// What the motors are to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rendered {
    /// Force on the handle, in `d` \[uN\].
    pub force_un: [i32; 3],
    /// Torque on the handle about its origin, in `d` \[uN m\].
    pub torque_unm: [i32; 3],
    /// The motors are shorted and damp the handle.
    pub braked: bool,
}

/// Messages to send, in order, and how many did not fit.
#[derive(Clone, Debug, Default)]
pub struct Outbox {
    messages: heapless::Vec<FromDevice, OUTBOX>,
    dropped: u32,
}

/// Messages that one call can leave at most: a report, a fault, and answers to a burst of hellos.
const OUTBOX: usize = 8;

impl Outbox {
    /// Empties it; yields what was in it.
    pub fn take(&mut self) -> impl Iterator<Item = FromDevice> + use<> {
        let (messages, mut at) = (core::mem::take(&mut self.messages), 0);
        // the list's own iterator has a panic path, and an image of firmware may have none
        core::iter::from_fn(move || {
            at += 1;
            messages.get(at - 1).copied()
        })
    }

    /// Messages that did not fit, since the start.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }

    fn send(&mut self, message: FromDevice) {
        if self.messages.push(message).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }
}

/// The firmware's state.
#[derive(Clone, Debug)]
pub struct Logic {
    limits: Limits,
    mode: Mode,
    fault: Option<DeviceFault>,
    /// Host and device have agreed on the tables, and the host was heard within [`SESSION_TICKS`].
    session: bool,
    /// A message out of turn has been answered since the last hello.
    scolded: bool,
    t_us: u32,
    seq: u32,
    period_us: u32,
    until_report_us: u32,
    since_host: u32,
    since_wrench: u32,
    accepted: Option<u32>,
    force_un: [i32; 3],
    torque_unm: [i32; 3],
    hold_left_us: u32,
    fade_left: u32,
    flags: u8,
}

impl Logic {
    /// Firmware after power-up.
    #[must_use]
    pub const fn new(limits: Limits) -> Self {
        Self {
            limits,
            mode: Mode::Reset,
            fault: None,
            session: false,
            scolded: false,
            t_us: 0,
            seq: 0,
            period_us: DEFAULT_PERIOD_US,
            until_report_us: 0,
            since_host: 0,
            since_wrench: 0,
            accepted: None,
            force_un: [0; 3],
            torque_unm: [0; 3],
            hold_left_us: 0,
            fade_left: 0,
            flags: 0,
        }
    }

    /// The mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Time between two reports \[us\].
    #[must_use]
    pub const fn period_us(&self) -> u32 {
        self.period_us
    }

    /// The latched fault.
    #[must_use]
    pub const fn fault(&self) -> Option<DeviceFault> {
        self.fault
    }

    /// Takes one message of the host.
    pub fn receive(&mut self, message: ToDevice, out: &mut Outbox) {
        self.since_host = 0;
        match message {
            ToDevice::Hello(hello) => self.hello(hello, out),
            ToDevice::SetMode(mode) => self.set_mode(mode, out),
            ToDevice::Wrench(command) => self.wrench(command, out),
        }
    }

    /// Lets [`TICK_US`] pass; yields what the motors are to do until the next tick.
    pub fn tick(&mut self, sensed: &Sensed, out: &mut Outbox) -> Rendered {
        self.t_us = self.t_us.wrapping_add(TICK_US);
        self.check_session();
        self.check_speed(sensed, out);
        self.check_watchdog(out);
        let rendered = self.render();
        self.report(sensed, out);
        rendered
    }

    fn hello(&mut self, hello: HostHello, out: &mut Outbox) {
        out.send(FromDevice::Hello(DeviceHello {
            version: PROTOCOL_VERSION,
            schema: SCHEMA_HASH,
            name: self.limits.name,
            serial: self.limits.serial,
            max_force_un: self.limits.max_force_un,
            max_torque_unm: self.limits.max_torque_unm,
            watchdog_ticks: self.limits.watchdog_ticks,
        }));
        self.zero_wrench();
        self.accepted = None;
        self.scolded = false;
        self.session = check_device_version(hello.version, hello.schema).is_ok();
        self.period_us = match hello.period_us {
            0 => DEFAULT_PERIOD_US,
            asked => asked.clamp(TICK_US, LONGEST_PERIOD_US),
        };
        self.until_report_us = 0;
        if self.mode != Mode::Brake {
            self.mode = if self.session { Mode::Idle } else { Mode::Reset };
        }
        if !self.session {
            self.tell(FaultCause::VersionMismatch, i32::from(PROTOCOL_VERSION), out);
        }
    }

    fn set_mode(&mut self, asked: Mode, out: &mut Outbox) {
        match (self.mode, asked) {
            (_, Mode::Reset) => self.reset(),
            // latched: only Reset leaves it, and the reports say so
            (Mode::Brake, _) => {}
            (_, Mode::Brake) => self.brake(),
            _ if !self.session => self.scold(out),
            (_, Mode::Idle) => {
                self.zero_wrench();
                self.mode = Mode::Idle;
            }
            (Mode::Idle, Mode::Force) => {
                self.zero_wrench();
                self.since_wrench = 0;
                self.mode = Mode::Force;
            }
            (Mode::Force, Mode::Force) => {}
            (Mode::Reset, Mode::Force) => self.scold(out),
        }
    }

    fn wrench(&mut self, command: WrenchCommand, out: &mut Outbox) {
        match self.mode {
            Mode::Reset if !self.session => return self.scold(out),
            Mode::Reset | Mode::Brake => return,
            Mode::Idle | Mode::Force => {}
        }
        if !self.is_newer(command.seq) {
            return;
        }
        let mut components = command.force_un.iter().chain(&command.torque_unm);
        if components.any(|&c| c == NOT_A_NUMBER) {
            return self.latch(FaultCause::NonFinite, command.seq as i32, out);
        }
        self.accepted = Some(command.seq);
        if self.mode == Mode::Force {
            self.since_wrench = 0;
            self.take_wrench(&command);
        }
    }

    /// Whether a command comes after the last accepted one, numbers wrapping.
    fn is_newer(&self, seq: u32) -> bool {
        self.accepted.is_none_or(|last| (seq.wrapping_sub(last) as i32) > 0)
    }

    fn take_wrench(&mut self, command: &WrenchCommand) {
        let (force, force_cut) = shorten(command.force_un, self.limits.max_force_un);
        let (torque, torque_cut) = shorten(command.torque_unm, self.limits.max_torque_unm);
        self.force_un = force;
        self.torque_unm = torque;
        self.hold_left_us = command.hold_us;
        self.fade_left = FADE_TICKS;
        if force_cut {
            self.flags |= PoseReport::FLAG_FORCE_CLAMPED;
        }
        if torque_cut {
            self.flags |= match self.limits.max_torque_unm {
                0 => PoseReport::FLAG_TORQUE_NOT_RENDERED,
                _ => PoseReport::FLAG_TORQUE_CLAMPED,
            };
        }
    }

    fn check_session(&mut self) {
        self.since_host = self.since_host.saturating_add(1);
        // in Force the watchdog rules
        if self.mode == Mode::Force || self.since_host <= SESSION_TICKS {
            return;
        }
        self.session = false;
        if self.mode == Mode::Idle {
            self.reset();
        }
    }

    fn check_speed(&mut self, sensed: &Sensed, out: &mut Outbox) {
        if self.mode != Mode::Force {
            return;
        }
        let detail = if sensed.speed_um_s > self.limits.over_speed_um_s {
            i32::try_from(sensed.speed_um_s).unwrap_or(i32::MAX)
        } else if sensed.spin_urad_s > self.limits.over_spin_urad_s {
            -i32::try_from(sensed.spin_urad_s).unwrap_or(i32::MAX)
        } else {
            return;
        };
        self.latch(FaultCause::OverSpeed, detail, out);
    }

    fn check_watchdog(&mut self, out: &mut Outbox) {
        if self.mode != Mode::Force {
            return;
        }
        self.since_wrench = self.since_wrench.saturating_add(1);
        let waited = self.since_wrench;
        if waited >= u32::from(self.limits.watchdog_ticks) {
            let detail = i32::try_from(waited).unwrap_or(i32::MAX);
            self.latch(FaultCause::Watchdog, detail, out);
        }
    }

    /// The wrench held, then faded; zero in every mode but `Force`.
    fn render(&mut self) -> Rendered {
        if self.mode != Mode::Force {
            return Rendered { braked: self.mode == Mode::Brake, ..Rendered::default() };
        }
        let share = self.fade_left;
        if self.hold_left_us > 0 {
            self.hold_left_us = self.hold_left_us.saturating_sub(TICK_US);
        } else {
            self.fade_left = self.fade_left.saturating_sub(1);
        }
        Rendered {
            force_un: scale(self.force_un, share, FADE_TICKS),
            torque_unm: scale(self.torque_unm, share, FADE_TICKS),
            braked: false,
        }
    }

    fn report(&mut self, sensed: &Sensed, out: &mut Outbox) {
        if !self.session {
            return;
        }
        self.until_report_us = self.until_report_us.saturating_sub(TICK_US);
        if self.until_report_us > 0 {
            return;
        }
        self.until_report_us = self.period_us;
        out.send(FromDevice::Pose(PoseReport {
            seq: self.seq,
            t_us: self.t_us,
            position_nm: sensed.position_nm,
            rotation_q30: sensed.rotation_q30,
            buttons: sensed.buttons,
            mode: self.mode,
            flags: self.flags | self.fault_flag(),
            echo: self.accepted.unwrap_or(0),
        }));
        self.seq = self.seq.wrapping_add(1);
        self.flags = 0;
    }

    /// The flag of the latched fault, so that a host that missed the message still learns of it.
    fn fault_flag(&self) -> u8 {
        match self.fault.map(|fault| fault.cause) {
            Some(FaultCause::OverSpeed) => PoseReport::FLAG_OVER_SPEED,
            Some(FaultCause::Watchdog) => PoseReport::FLAG_WATCHDOG,
            _ => 0,
        }
    }

    fn reset(&mut self) {
        self.zero_wrench();
        self.fault = None;
        self.flags = 0;
        // a host that has agreed on the tables need not say hello again
        self.mode = Mode::Reset;
    }

    fn brake(&mut self) {
        self.zero_wrench();
        self.mode = Mode::Brake;
    }

    fn latch(&mut self, cause: FaultCause, detail: i32, out: &mut Outbox) {
        self.brake();
        self.fault = Some(self.tell(cause, detail, out));
    }

    /// Answers a message out of turn, once until the next hello: a host that floods gets no flood back.
    fn scold(&mut self, out: &mut Outbox) {
        if !self.scolded {
            self.scolded = true;
            self.tell(FaultCause::Protocol, self.mode as i32, out);
        }
    }

    fn tell(&self, cause: FaultCause, detail: i32, out: &mut Outbox) -> DeviceFault {
        let fault = DeviceFault { cause, seq: self.seq.wrapping_sub(1), detail };
        out.send(FromDevice::Fault(fault));
        fault
    }

    fn zero_wrench(&mut self) {
        self.force_un = [0; 3];
        self.torque_unm = [0; 3];
        self.hold_left_us = 0;
        self.fade_left = 0;
    }
}
