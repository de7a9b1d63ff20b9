//! From an open link to a device that renders forces, and back there after anything went wrong.
//!
//! ```text
//!  Reset ──SetMode(Reset)──► Greet ──Hello──► (hello, versions agree) ──► Arm ──SetMode(Idle, Force)──► Run
//!    ▲                         │ versions differ ──► Refuse                                              │
//!    └── fault, restart, silence, new link ◄───────────────────────────────────────────────────────────┘
//! ```
//! While **stopped** (somebody hit the emergency stop) nothing is asked for but the brake, wherever the session stands and whatever happens to the link;
//! re-armed, it begins anew.
//! The first message is a reset, so that a fault or a session left by another host does not matter. Every request is repeated
//! until the device's answer shows it was heard.

use haptor_wire::device::{DeviceFault, DeviceHello, FaultCause, HostHello, Mode, PoseReport, ToDevice};
use haptor_wire::{HostFault, PROTOCOL_VERSION, SCHEMA_HASH, VersionMismatch, check_device_version};

use super::line::Arrivals;
use super::scale::ticks_at;

// Counts of ticks at the default rate ([`super::scale`]).

/// Ticks between two hellos while nobody answers: a hello takes the device back to idle, so a second must not overtake the answer.
const HELLO_EVERY: u32 = 100;

/// Ticks between two requests for a mode: reports already on their way still show the old one.
const MODE_EVERY: u32 = 10;

/// Ticks from a fault to the next attempt, so that a device with a standing fault is not asked a thousand times a second.
const RECOVER_AFTER: u32 = 100;

/// Ticks without a pose in a session after which the device is greeted anew: it may have forgotten the session.
const SILENT_AFTER: u32 = 250;

/// Where the session stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Ask for a reset, not before this tick.
    Reset {
        /// The earliest tick.
        from: u64,
    },
    /// Say hello until the device answers.
    Greet,
    /// Ask for the modes up to force.
    Arm,
    /// The device renders.
    Run,
    /// The device speaks another version: nothing more is said to it.
    Refuse(VersionMismatch),
}

/// The session's state.
#[derive(Clone, Copy, Debug)]
pub struct Handshake {
    phase: Phase,
    period_us: u32,
    asked_at: Option<u64>,
    silent: u32,
    device: Option<DeviceHello>,
    /// The mode of the newest report.
    mode: Mode,
    /// Somebody hit the emergency stop.
    stopped: bool,
}

impl Handshake {
    /// Begins anew with a request for reports every `period_us`.
    #[must_use]
    pub const fn new(period_us: u32) -> Self {
        Self {
            phase: Phase::Reset { from: 0 },
            period_us,
            asked_at: None,
            silent: 0,
            device: None,
            mode: Mode::Reset,
            stopped: false,
        }
    }

    /// Where the session stands.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// True while the device renders the wrenches it is sent.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.phase == Phase::Run && !self.stopped
    }

    /// True when the device has just reported and did not grant force.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        self.phase == Phase::Arm && self.mode == Mode::Idle && self.silent == 0
    }

    /// The device is to brake from now on.
    pub const fn stop(&mut self) {
        (self.stopped, self.asked_at) = (true, None);
    }

    /// Back from the emergency stop: begins anew.
    pub fn rearm(&mut self, tick: u64) {
        self.stopped = false;
        self.enter(Phase::Reset { from: tick });
    }

    /// True while the emergency stop holds.
    #[must_use]
    pub const fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// The mode that the device reported last.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Who the device is, by its last answer to a hello of ours.
    #[must_use]
    pub const fn device(&self) -> Option<DeviceHello> {
        self.device
    }

    /// Takes what came in a tick; yields the fault that it means.
    pub fn observe(&mut self, got: &Arrivals, tick: u64) -> Option<HostFault> {
        if got.reopened || got.lost {
            self.enter(Phase::Reset { from: tick });
        }
        let fault = if got.lost { Some(HostFault::LinkLost) } else { self.judge(got) };
        if fault.is_some_and(|fault| fault != HostFault::VersionMismatch) {
            self.enter(Phase::Reset { from: tick + self.ticks(RECOVER_AFTER) });
        }
        self.watch_silence(got, tick);
        fault
    }

    fn judge(&mut self, got: &Arrivals) -> Option<HostFault> {
        if let Some(hello) = &got.hello {
            let greeting = self.phase == Phase::Greet;
            let fault = self.greeted(hello);
            // a report that came with the answer may be older than it; a hello that nobody waits for hides nothing
            if greeting || fault.is_some() {
                return fault;
            }
        }
        if let Some(fault) = &got.fault
            && !matches!(self.phase, Phase::Refuse(_))
        {
            return Some(self.named(fault));
        }
        if got.restarted && self.is_running() {
            return Some(HostFault::DeviceRestarted);
        }
        got.pose.as_ref().and_then(|pose| self.follow(pose))
    }

    fn greeted(&mut self, hello: &DeviceHello) -> Option<HostFault> {
        match check_device_version(hello.version, hello.schema) {
            Err(mismatch) => {
                self.enter(Phase::Refuse(mismatch));
                Some(HostFault::VersionMismatch)
            }
            Ok(()) => {
                if self.phase == Phase::Greet {
                    self.device = Some(*hello);
                    self.enter(Phase::Arm);
                }
                None
            }
        }
    }

    /// A device that has no session any more calls our wrench out of turn: it has restarted behind a link that stayed up.
    fn named(&self, fault: &DeviceFault) -> HostFault {
        let forgot_us = fault.cause == FaultCause::Protocol && fault.detail == Mode::Reset as i32;
        if forgot_us && self.is_running() { HostFault::DeviceRestarted } else { fault.cause.into() }
    }

    /// Follows the device's mode.
    fn follow(&mut self, pose: &PoseReport) -> Option<HostFault> {
        self.mode = pose.mode;
        match (self.phase, pose.mode) {
            (Phase::Arm, Mode::Force) => self.enter(Phase::Run),
            (_, Mode::Brake) if self.stopped => {}
            (Phase::Run | Phase::Arm, Mode::Brake) => return Some(braked_for(pose.flags)),
            (Phase::Run, Mode::Reset) => return Some(HostFault::DeviceRestarted),
            // somebody rests the device, e.g. a switch on it: no fault; ask again, forces come back by the small-force rule
            (Phase::Run, Mode::Idle) => self.enter(Phase::Arm),
            _ => {}
        }
        None
    }

    fn watch_silence(&mut self, got: &Arrivals, tick: u64) {
        self.silent = if got.pose.is_some() { 0 } else { self.silent.saturating_add(1) };
        if u64::from(self.silent) >= self.ticks(SILENT_AFTER) && matches!(self.phase, Phase::Run | Phase::Arm) {
            self.enter(Phase::Reset { from: tick });
        }
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.asked_at = None;
        self.silent = 0;
    }

    /// What to say to the device in this tick, if anything but a wrench.
    pub fn ask(&mut self, tick: u64) -> Option<ToDevice> {
        let (message, every) = match self.phase {
            Phase::Refuse(_) => return None,
            _ if self.stopped && self.mode == Mode::Brake => return None,
            _ if self.stopped => (ToDevice::SetMode(Mode::Brake), MODE_EVERY),
            Phase::Reset { from } if tick >= from => {
                self.enter(Phase::Greet);
                return Some(ToDevice::SetMode(Mode::Reset));
            }
            Phase::Greet => (ToDevice::Hello(self.hello()), HELLO_EVERY),
            Phase::Arm if self.mode == Mode::Reset => (ToDevice::SetMode(Mode::Idle), MODE_EVERY),
            Phase::Arm => (ToDevice::SetMode(Mode::Force), MODE_EVERY),
            Phase::Reset { .. } | Phase::Run => return None,
        };
        if self.asked_at.is_some_and(|at| tick < at + self.ticks(every)) {
            return None;
        }
        self.asked_at = Some(tick);
        Some(message)
    }

    /// So many ticks of the default rate, at this one.
    fn ticks(&self, ticks: u32) -> u64 {
        ticks_at(1_000_000 / self.period_us, ticks).into()
    }

    const fn hello(&self) -> HostHello {
        HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: self.period_us }
    }
}

/// Why a device brakes, by the flags of its report: its fault message may have been lost.
const fn braked_for(flags: u8) -> HostFault {
    if flags & PoseReport::FLAG_WATCHDOG != 0 {
        HostFault::DeviceWatchdog
    } else if flags & PoseReport::FLAG_OVER_SPEED != 0 {
        HostFault::DeviceOverSpeed
    } else {
        HostFault::DeviceFault
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hello(version: u16) -> Arrivals {
        let hello = DeviceHello {
            version,
            schema: SCHEMA_HASH,
            name: [0; 12],
            serial: [0; 12],
            max_force_un: 8_500_000,
            max_torque_unm: 188_000,
            watchdog_ticks: 160,
        };
        Arrivals { hello: Some(hello), ..Arrivals::default() }
    }

    fn pose(mode: Mode, flags: u8) -> Arrivals {
        let pose = PoseReport {
            seq: 0,
            t_us: 0,
            position_nm: [0; 3],
            rotation_q30: [1 << 30, 0, 0, 0],
            buttons: 0,
            mode,
            flags,
            echo: 0,
        };
        Arrivals { pose: Some(pose), ..Arrivals::default() }
    }

    fn running() -> Handshake {
        let mut h = Handshake::new(1000);
        h.ask(0);
        h.observe(&hello(PROTOCOL_VERSION), 1);
        h.observe(&pose(Mode::Force, 0), 2);
        assert!(h.is_running());
        h
    }

    #[test]
    fn the_steps_to_force() {
        let mut h = Handshake::new(1000);
        assert_eq!(h.ask(0), Some(ToDevice::SetMode(Mode::Reset)));
        assert!(matches!(h.ask(1), Some(ToDevice::Hello(hello)) if hello.period_us == 1000));
        assert_eq!(h.ask(2), None);
        assert!(matches!(h.ask(1 + u64::from(HELLO_EVERY)), Some(ToDevice::Hello(_))), "nobody answered");
        assert_eq!(h.observe(&hello(PROTOCOL_VERSION), 102), None);
        assert_eq!(h.ask(102), Some(ToDevice::SetMode(Mode::Idle)));
        h.observe(&pose(Mode::Idle, 0), 103);
        assert_eq!(h.ask(102 + u64::from(MODE_EVERY)), Some(ToDevice::SetMode(Mode::Force)));
        h.observe(&pose(Mode::Force, 0), 120);
        assert_eq!((h.is_running(), h.ask(121)), (true, None));
    }

    #[test]
    fn another_version_is_refused_with_both_numbers() {
        let mut h = Handshake::new(1000);
        h.ask(0);
        assert_eq!(h.observe(&hello(PROTOCOL_VERSION + 1), 1), Some(HostFault::VersionMismatch));
        let Phase::Refuse(mismatch) = h.phase() else { panic!("{:?}", h.phase()) };
        assert_eq!((mismatch.our_version, mismatch.their_version), (PROTOCOL_VERSION, PROTOCOL_VERSION + 1));
        assert_eq!(h.ask(10_000), None);
    }

    #[test]
    fn what_ends_a_session_and_what_it_is_called() {
        let fault = |cause, detail| Arrivals { fault: Some(DeviceFault { cause, seq: 0, detail }), ..Arrivals::default() };
        let table = [
            (Arrivals { lost: true, ..Arrivals::default() }, HostFault::LinkLost),
            (Arrivals { restarted: true, ..pose(Mode::Force, 0) }, HostFault::DeviceRestarted),
            (pose(Mode::Reset, 0), HostFault::DeviceRestarted),
            (fault(FaultCause::Protocol, 0), HostFault::DeviceRestarted),
            (fault(FaultCause::Protocol, 1), HostFault::DeviceFault),
            (fault(FaultCause::Watchdog, 9), HostFault::DeviceWatchdog),
            (pose(Mode::Brake, PoseReport::FLAG_OVER_SPEED), HostFault::DeviceOverSpeed),
            (pose(Mode::Brake, 0), HostFault::DeviceFault),
        ];
        for (got, expected) in table {
            let mut h = running();
            assert_eq!(h.observe(&got, 50), Some(expected), "{got:?}");
            assert_eq!(h.ask(50 + u64::from(RECOVER_AFTER) - 1), None);
            assert_eq!(h.ask(50 + u64::from(RECOVER_AFTER)), Some(ToDevice::SetMode(Mode::Reset)));
        }
    }

    #[test]
    fn stopped_it_asks_for_the_brake_and_nothing_else_until_re_armed() {
        let mut h = running();
        h.stop();
        assert_eq!((h.is_running(), h.ask(50)), (false, Some(ToDevice::SetMode(Mode::Brake))));
        assert_eq!(
            (h.ask(51), h.ask(50 + u64::from(MODE_EVERY))),
            (None, Some(ToDevice::SetMode(Mode::Brake))),
            "repeated until it is seen"
        );
        assert_eq!(h.observe(&pose(Mode::Brake, 0), 61), None, "a brake that was asked for is no fault");
        assert_eq!(h.ask(1000), None);
        // a device that lost its power meanwhile is asked again, and not greeted
        assert_eq!(h.observe(&Arrivals { restarted: true, ..pose(Mode::Reset, 0) }, 1001), Some(HostFault::DeviceRestarted));
        assert_eq!(h.ask(1001 + u64::from(RECOVER_AFTER)), Some(ToDevice::SetMode(Mode::Brake)));
        h.rearm(2000);
        assert_eq!(h.ask(2000), Some(ToDevice::SetMode(Mode::Reset)));
        assert!(matches!(h.ask(2001), Some(ToDevice::Hello(_))));
    }

    #[test]
    fn a_hello_that_nobody_waits_for_hides_no_fault_and_changes_no_limits() {
        let stranger = DeviceHello { max_force_un: 1, ..hello(PROTOCOL_VERSION).hello.unwrap() };
        let fault = DeviceFault { cause: FaultCause::Hardware, seq: 0, detail: 0 };
        for (got, expected) in [
            (Arrivals { fault: Some(fault), ..pose(Mode::Force, 0) }, Some(HostFault::DeviceFault)),
            (pose(Mode::Brake, PoseReport::FLAG_WATCHDOG), Some(HostFault::DeviceWatchdog)),
            (Arrivals { restarted: true, ..pose(Mode::Force, 0) }, Some(HostFault::DeviceRestarted)),
            (pose(Mode::Force, 0), None),
        ] {
            let mut h = running();
            let before = h.device();
            assert_eq!(h.observe(&Arrivals { hello: Some(stranger), ..got }, 50), expected, "{got:?}");
            assert_eq!((h.device(), h.is_running()), (before, expected.is_none()), "{got:?}");
        }
    }

    #[test]
    fn a_device_refuses_when_it_reports_and_does_not_grant_force() {
        let mut h = Handshake::new(1000);
        h.ask(0);
        h.observe(&hello(PROTOCOL_VERSION), 1);
        for (got, expected) in [
            (pose(Mode::Reset, 0), false),
            (pose(Mode::Idle, 0), true),
            (Arrivals::default(), false),
            (pose(Mode::Idle, 0), true),
            (pose(Mode::Force, 0), false),
        ] {
            h.observe(&got, 2);
            assert_eq!(h.is_refused(), expected, "{got:?}");
        }
    }

    #[test]
    fn a_silent_device_is_greeted_anew() {
        let mut h = running();
        (0..u64::from(SILENT_AFTER)).for_each(|tick| assert_eq!(h.observe(&Arrivals::default(), tick), None));
        assert_eq!(h.ask(SILENT_AFTER.into()), Some(ToDevice::SetMode(Mode::Reset)));
    }
}
