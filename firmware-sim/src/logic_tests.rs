//! The firmware's rules, message by message and tick by tick.

use std::vec::Vec;

use haptor_wire::units::NOT_A_NUMBER;
use haptor_wire::{
    DeviceFault, FaultCause, FromDevice, HostHello, Mode, PROTOCOL_VERSION, PoseReport, SCHEMA_HASH, ToDevice, WrenchCommand,
};

use crate::logic::{FADE_TICKS, Limits, Logic, Outbox, Rendered, SESSION_TICKS, Sensed};
use crate::preset::{PREMIUM15, TOUCH, WATCHDOG_TICKS};

const HELLO: HostHello = HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 };

const STILL: Sensed =
    Sensed { position_nm: [1, 2, 3], rotation_q30: [1 << 30, 0, 0, 0], buttons: 0b10, speed_um_s: 0, spin_urad_s: 0 };

struct Bench {
    logic: Logic,
    outbox: Outbox,
    said: Vec<FromDevice>,
    seq: u32,
}

impl Bench {
    fn new(limits: Limits) -> Self {
        Self { logic: Logic::new(limits), outbox: Outbox::default(), said: Vec::new(), seq: 0 }
    }

    fn in_force() -> Self {
        let mut bench = Self::new(PREMIUM15.limits("T"));
        bench.hear(ToDevice::Hello(HELLO));
        bench.hear(ToDevice::SetMode(Mode::Force));
        assert_eq!(bench.logic.mode(), Mode::Force);
        bench
    }

    fn hear(&mut self, message: ToDevice) {
        self.logic.receive(message, &mut self.outbox);
        self.said.extend(self.outbox.take());
    }

    fn tick(&mut self, sensed: &Sensed) -> Rendered {
        let rendered = self.logic.tick(sensed, &mut self.outbox);
        self.said.extend(self.outbox.take());
        rendered
    }

    fn ticks(&mut self, n: u32) -> Rendered {
        (0..n).map(|_| self.tick(&STILL)).last().unwrap()
    }

    fn wrench(&mut self, force_un: [i32; 3], torque_unm: [i32; 3], hold_us: u32) {
        self.seq += 1;
        let command = WrenchCommand { seq: self.seq, echo: 0, force_un, torque_unm, hold_us };
        self.hear(ToDevice::Wrench(command));
    }

    fn faults(&self) -> Vec<DeviceFault> {
        let faults = self.said.iter().filter_map(|message| match message {
            FromDevice::Fault(fault) => Some(*fault),
            _ => None,
        });
        faults.collect()
    }

    fn poses(&self) -> Vec<PoseReport> {
        let poses = self.said.iter().filter_map(|message| match message {
            FromDevice::Pose(pose) => Some(*pose),
            _ => None,
        });
        poses.collect()
    }

    /// Flags of all reports of the next period, or-ed.
    fn next_flags(&mut self) -> u8 {
        self.said.clear();
        self.ticks(8);
        self.poses().iter().fold(0, |all, pose| all | pose.flags)
    }

    fn next_pose(&mut self) -> PoseReport {
        self.said.clear();
        self.ticks(8);
        self.poses()[0]
    }
}

#[test]
fn modes_change_as_the_table_says() {
    use Mode::{Brake, Force, Idle, Reset};
    // mode, agreed on the tables, asked for, mode then
    let table = [
        (Reset, false, Idle, Reset),
        (Reset, false, Force, Reset),
        (Reset, false, Brake, Brake),
        (Reset, true, Idle, Idle),
        (Reset, true, Force, Reset),
        (Reset, true, Brake, Brake),
        (Idle, true, Reset, Reset),
        (Idle, true, Idle, Idle),
        (Idle, true, Force, Force),
        (Idle, true, Brake, Brake),
        (Force, true, Reset, Reset),
        (Force, true, Idle, Idle),
        (Force, true, Force, Force),
        (Force, true, Brake, Brake),
        (Brake, true, Reset, Reset),
        (Brake, true, Idle, Brake),
        (Brake, true, Force, Brake),
        (Brake, true, Brake, Brake),
    ];
    for (from, agreed, asked, then) in table {
        let mut bench = Bench::new(PREMIUM15.limits("T"));
        if agreed {
            bench.hear(ToDevice::Hello(HELLO));
        }
        match from {
            Reset => bench.hear(ToDevice::SetMode(Reset)),
            Idle => {}
            other => {
                bench.hear(ToDevice::SetMode(Force));
                bench.hear(ToDevice::SetMode(other));
            }
        }
        assert_eq!(bench.logic.mode(), from);
        bench.hear(ToDevice::SetMode(asked));
        assert_eq!(bench.logic.mode(), then, "{from:?}, {agreed}, asked {asked:?}");
    }
}

#[test]
fn a_hello_is_answered_and_opens_the_session() {
    let mut bench = Bench::new(PREMIUM15.limits("SER"));
    bench.ticks(100);
    assert_eq!(bench.said, [], "silent before the first hello");
    bench.hear(ToDevice::Hello(HELLO));
    let FromDevice::Hello(hello) = bench.said[0] else { panic!("{:?}", bench.said) };
    assert_eq!((hello.version, hello.schema), (PROTOCOL_VERSION, SCHEMA_HASH));
    assert_eq!((hello.max_force_un, hello.max_torque_unm), (8_500_000, 188_000));
    assert!(hello.name_chars().eq("premium15".chars()));
    assert!(hello.serial_chars().eq("SER".chars()));
    assert_eq!(bench.logic.mode(), Mode::Idle);
}

#[test]
fn another_version_or_table_is_told_and_opens_nothing() {
    for hello in [HostHello { version: PROTOCOL_VERSION + 1, ..HELLO }, HostHello { schema: !SCHEMA_HASH, ..HELLO }] {
        let mut bench = Bench::new(PREMIUM15.limits("T"));
        bench.hear(ToDevice::Hello(hello));
        assert!(matches!(bench.said[0], FromDevice::Hello(_)));
        let fault = bench.faults()[0];
        assert_eq!(fault.cause, FaultCause::VersionMismatch);
        assert_eq!(fault.detail, i32::from(PROTOCOL_VERSION));
        bench.hear(ToDevice::SetMode(Mode::Force));
        assert_eq!(bench.logic.mode(), Mode::Reset);
        bench.ticks(100);
        assert_eq!(bench.poses(), []);
    }
}

#[test]
fn messages_out_of_turn_are_answered_once() {
    let mut bench = Bench::new(PREMIUM15.limits("T"));
    for _ in 0..100 {
        bench.wrench([0; 3], [0; 3], 0);
        bench.hear(ToDevice::SetMode(Mode::Force));
    }
    let causes: Vec<_> = bench.faults().iter().map(|fault| fault.cause).collect();
    assert_eq!(causes, [FaultCause::Protocol]);
    assert_eq!(bench.logic.mode(), Mode::Reset);
}

#[test]
fn reports_come_once_a_period_and_carry_what_is_sensed() {
    for (asked, period, in_1000_ticks) in [(1000, 1000, 125), (0, 1000, 125), (125, 125, 1000), (1, 125, 1000)] {
        let mut bench = Bench::new(PREMIUM15.limits("T"));
        bench.hear(ToDevice::Hello(HostHello { period_us: asked, ..HELLO }));
        bench.ticks(1000);
        let poses = bench.poses();
        assert_eq!(poses.len(), in_1000_ticks, "asked for {asked} us");
        for (i, pair) in poses.windows(2).enumerate() {
            assert_eq!(pair[0].seq, i as u32);
            assert_eq!(pair[1].t_us - pair[0].t_us, period);
        }
        assert_eq!(poses[0].position_nm, STILL.position_nm);
        assert_eq!(poses[0].rotation_q30, STILL.rotation_q30);
        assert_eq!(poses[0].buttons, STILL.buttons);
        assert_eq!((poses[0].mode, poses[0].flags, poses[0].echo), (Mode::Idle, 0, 0));
    }
}

#[test]
fn the_watchdog_brakes_at_its_tick_and_not_before() {
    for answered in [0, 1, 100] {
        let mut bench = Bench::in_force();
        for _ in 0..answered {
            bench.wrench([1_000_000, 0, 0], [0; 3], 1_000_000);
            bench.ticks(8);
        }
        let already = if answered == 0 { 0 } else { 8 };
        bench.ticks(u32::from(WATCHDOG_TICKS) - 1 - already);
        assert_eq!(bench.logic.mode(), Mode::Force);
        let rendered = bench.ticks(1);
        assert_eq!(bench.logic.mode(), Mode::Brake);
        assert_eq!(rendered, Rendered { braked: true, ..Rendered::default() });
        let fault = bench.faults()[0];
        assert_eq!(fault.cause, FaultCause::Watchdog);
        assert_eq!(fault.detail, i32::from(WATCHDOG_TICKS));
        assert_eq!(bench.next_pose().flags, PoseReport::FLAG_WATCHDOG);
    }
}

#[test]
fn a_fault_stays_until_reset() {
    let mut bench = Bench::in_force();
    bench.ticks(u32::from(WATCHDOG_TICKS));
    assert_eq!(bench.faults().len(), 1);
    for message in [ToDevice::SetMode(Mode::Idle), ToDevice::SetMode(Mode::Force), ToDevice::Hello(HELLO)] {
        bench.hear(message);
        bench.wrench([1_000_000, 0, 0], [0; 3], 1000);
        assert_eq!(bench.ticks(8).force_un, [0; 3]);
        assert_eq!(bench.logic.mode(), Mode::Brake, "{message:?}");
        assert_eq!(bench.next_pose().flags, PoseReport::FLAG_WATCHDOG);
    }
    bench.hear(ToDevice::SetMode(Mode::Reset));
    assert_eq!(bench.logic.fault(), None);
    bench.hear(ToDevice::SetMode(Mode::Idle));
    bench.hear(ToDevice::SetMode(Mode::Force));
    bench.wrench([1_000_000, 0, 0], [0; 3], 1000);
    assert_eq!(bench.tick(&STILL).force_un, [1_000_000, 0, 0]);
    assert_eq!(bench.next_pose().flags, 0);
}

#[test]
fn a_command_that_is_not_a_number_is_refused_wherever_it_is() {
    for at in 0..6 {
        let mut bench = Bench::in_force();
        bench.wrench([1_000_000, 0, 0], [0; 3], 100_000);
        let (mut force, mut torque) = ([2_000_000; 3], [2_000; 3]);
        if at < 3 {
            force[at] = NOT_A_NUMBER;
        } else {
            torque[at - 3] = NOT_A_NUMBER;
        }
        bench.wrench(force, torque, 100_000);
        let fault = bench.faults()[0];
        assert_eq!((fault.cause, fault.detail), (FaultCause::NonFinite, 2));
        assert_eq!(bench.tick(&STILL).force_un, [0; 3]);
        assert_eq!(bench.logic.mode(), Mode::Brake);
        assert_eq!(bench.next_pose().echo, 1, "the refused command is not echoed");
    }
}

#[test]
fn over_speed_brakes_and_tells_how_fast() {
    let fast = Sensed { speed_um_s: 1_000_001, ..STILL };
    let spinning = Sensed { spin_urad_s: 20_000_001, ..STILL };
    let at_limit = Sensed { speed_um_s: 1_000_000, spin_urad_s: 20_000_000, ..STILL };
    for (sensed, detail) in [(fast, 1_000_001), (spinning, -20_000_001)] {
        let mut bench = Bench::in_force();
        bench.wrench([1_000_000, 0, 0], [0; 3], 100_000);
        assert_eq!(bench.tick(&at_limit).force_un, [1_000_000, 0, 0]);
        assert!(bench.tick(&sensed).braked);
        let fault = bench.faults()[0];
        assert_eq!((fault.cause, fault.detail), (FaultCause::OverSpeed, detail));
        assert_eq!(bench.next_pose().flags, PoseReport::FLAG_OVER_SPEED);
    }
    // a free hand may be fast
    let mut bench = Bench::new(PREMIUM15.limits("T"));
    bench.hear(ToDevice::Hello(HELLO));
    bench.tick(&fast);
    assert_eq!(bench.logic.mode(), Mode::Idle);
}

#[test]
fn limits_cut_force_and_torque_apart_and_say_so_once() {
    let clamped_force = PoseReport::FLAG_FORCE_CLAMPED;
    let clamped_torque = PoseReport::FLAG_TORQUE_CLAMPED;
    let table = [
        ([8_500_000, 0, 0], [0, 0, 188_000], 0),
        ([17_000_000, 0, 0], [0, 0, 100], clamped_force),
        ([1, 0, 0], [0, 0, 376_000], clamped_torque),
        ([0, 17_000_000, 0], [0, 376_000, 0], clamped_force | clamped_torque),
    ];
    for (force, torque, flags) in table {
        let mut bench = Bench::in_force();
        bench.next_pose();
        bench.wrench(force, torque, 100_000);
        let rendered = bench.logic.clone().tick(&STILL, &mut Outbox::default());
        for (asked, got, limit) in [(force, rendered.force_un, 8_500_000), (torque, rendered.torque_unm, 188_000)] {
            let expected = asked.map(|c: i32| c.min(limit));
            for (e, g) in expected.iter().zip(&got) {
                assert!((e - g).abs() <= 1, "{expected:?}, got {got:?}");
            }
        }
        assert_eq!(bench.next_flags(), flags);
        assert_eq!(bench.next_flags(), 0, "told once per command");
    }
}

#[test]
fn torque_that_cannot_be_rendered_is_told() {
    let mut bench = Bench::new(TOUCH.limits("T"));
    bench.hear(ToDevice::Hello(HELLO));
    bench.hear(ToDevice::SetMode(Mode::Force));
    bench.wrench([1_000_000, 0, 0], [0; 3], 100_000);
    assert_eq!(bench.next_pose().flags, 0);
    bench.wrench([1_000_000, 0, 0], [0, 0, 1], 100_000);
    assert_eq!(bench.next_flags(), PoseReport::FLAG_TORQUE_NOT_RENDERED);
    assert_eq!(bench.next_flags(), 0, "told once per command");
    let rendered = bench.tick(&STILL);
    assert_eq!(rendered.force_un, [1_000_000, 0, 0]);
    assert_eq!(rendered.torque_unm, [0; 3]);
}

#[test]
fn a_wrench_is_held_then_fades_to_zero_without_a_jump() {
    let mut bench = Bench::in_force();
    bench.wrench([800_000, 0, 0], [0, 0, 80_000], 2000);
    let forces: Vec<i32> = (0..120).map(|_| bench.tick(&STILL).force_un[0]).collect();
    assert!(forces[..16].iter().all(|&f| f == 800_000), "{forces:?}");
    let step = 800_000 / FADE_TICKS as i32;
    for pair in forces[16..].windows(2) {
        assert!((0..=step).contains(&(pair[0] - pair[1])), "{pair:?}");
    }
    assert_eq!(forces[16 + FADE_TICKS as usize..], [0; 24]);
    assert_eq!(bench.logic.mode(), Mode::Force, "the watchdog is another matter");
}

#[test]
fn old_and_repeated_commands_are_ignored_and_numbers_may_wrap() {
    let mut bench = Bench::in_force();
    let command = |seq, force| {
        ToDevice::Wrench(WrenchCommand { seq, echo: 0, force_un: [force, 0, 0], torque_unm: [0; 3], hold_us: 100_000 })
    };
    let table = [
        (u32::MAX - 1, 10, 10),
        (u32::MAX - 1, 11, 10),
        (u32::MAX - 5, 12, 10),
        (u32::MAX, 13, 13),
        (3, 14, 14),
        (2, 15, 14),
        (3, NOT_A_NUMBER, 14),
    ];
    for (seq, force, rendered) in table {
        bench.hear(command(seq, force));
        assert_eq!(bench.tick(&STILL).force_un[0], rendered, "{seq}");
    }
    assert_eq!(bench.next_pose().echo, 3);
}

#[test]
fn idle_renders_nothing_but_echoes() {
    let mut bench = Bench::new(PREMIUM15.limits("T"));
    bench.hear(ToDevice::Hello(HELLO));
    bench.wrench([1_000_000, 0, 0], [0; 3], 100_000);
    assert_eq!(bench.tick(&STILL), Rendered::default());
    assert_eq!(bench.next_pose().echo, 1);
    bench.hear(ToDevice::SetMode(Mode::Force));
    assert_eq!(bench.tick(&STILL).force_un, [0; 3], "nothing from before is rendered");
}

#[test]
fn a_host_that_falls_silent_ends_the_session() {
    let mut bench = Bench::new(PREMIUM15.limits("T"));
    bench.hear(ToDevice::Hello(HELLO));
    bench.ticks(SESSION_TICKS);
    assert_eq!(bench.logic.mode(), Mode::Idle);
    bench.ticks(1);
    assert_eq!(bench.logic.mode(), Mode::Reset);
    bench.said.clear();
    bench.ticks(100);
    assert_eq!(bench.said, [], "and so does the device");
}

#[test]
fn a_flood_of_hellos_is_bounded() {
    let mut bench = Bench::new(PREMIUM15.limits("T"));
    for _ in 0..100 {
        bench.logic.receive(ToDevice::Hello(HELLO), &mut bench.outbox);
    }
    assert_eq!(bench.outbox.take().count(), 8);
    assert_eq!(bench.outbox.dropped(), 92);
}
