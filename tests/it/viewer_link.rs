//! The viewer link from end to end: real sockets, real threads, a session on the rig's clock. What viewers see is what happened, what they ask is
//! done in order, and whatever they do, the ticks of the session are the same.

use std::collections::HashMap;

use haptor_contact::{Pose, Quat, Vec3};
use haptor_engine::{OwnedEngine, Placed, Scene};
use haptor_host::rt::desk::VIEWERS_MAX;
use haptor_host::rt::flags;
use haptor_host::rt::stale::{CALM_TICKS, FADE_TICKS, HOLD_TICKS, SMALL_FORCE};
use haptor_host::viewer::token::Token;
use haptor_wire::viewer::NO_TOKEN;
use haptor_wire::{
    BakedScene, Denial, DeviceHello, FromViewer, Mode, ObjectShape, OutputState, PROTOCOL_VERSION, Record, RecordReader, Refusal,
    RefusalCause, RestBegin, RestPoints, SCHEMA_HASH, Snapshot, Statistics, TickRecord, Tier, ToViewer, Tuning, UploadBegin,
    UploadChunk, VIEWER_SCHEMA_HASH, ViewerHello, What, Wish, WorkBudget, encode_stream, scene_file,
};

use crate::alloc::counted;
use crate::host_rig::{Rig, ball_on_cube, length};
use crate::viewer::{TestViewer, file};
use crate::viewer_rig::Served;

fn snapshot(message: &ToViewer) -> Option<Snapshot> {
    match message {
        ToViewer::Snapshot(snapshot) => Some(snapshot.clone()),
        _ => None,
    }
}

fn statistics(message: &ToViewer) -> Option<Statistics> {
    match message {
        ToViewer::Statistics(statistics) => Some(*statistics),
        _ => None,
    }
}

fn event(what: What) -> impl FnMut(&ToViewer) -> Option<u64> {
    move |message| match message {
        ToViewer::Event(event) if event.what == what => Some(event.tick),
        _ => None,
    }
}

/// The cube, harder: another scene for the same device.
fn hard_cube() -> BakedScene {
    BakedScene { young_modulus: 6.0e6, ..ball_on_cube() }
}

/// A session of the same script on which nobody looks.
fn alone(script: &str, ticks: usize) -> Vec<TickRecord> {
    let mut rig = Rig::new(script, None);
    while rig.ticks.len() < ticks {
        rig.tick();
    }
    rig.ticks
}

#[test]
fn another_version_or_table_is_refused_with_both_numbers() {
    let served = Served::new("press");
    let table = [(PROTOCOL_VERSION + 3, VIEWER_SCHEMA_HASH), (PROTOCOL_VERSION, 0x0BAD_CAFE)];
    for (version, schema) in table {
        let mut viewer = served.stranger();
        viewer.say(&FromViewer::Hello(ViewerHello { version, schema, token: NO_TOKEN }));
        let said = viewer.until_closed();
        assert_eq!(said, Some(ToViewer::Refused(Refusal::new(RefusalCause::Version))));
        // what a viewer of that other build would print
        let Some(ToViewer::Refused(refusal)) = said else { unreachable!() };
        assert_eq!((refusal.version, refusal.schema), (PROTOCOL_VERSION, VIEWER_SCHEMA_HASH));
    }
    served.end();
}

#[test]
fn only_who_knows_the_token_comes_in() {
    let token = Token::generate().unwrap();
    let said: Vec<u8> = (0..32).map(|i| u8::from_str_radix(&token.to_hex()[2 * i..2 * i + 2], 16).unwrap()).collect();
    let right: [u8; 32] = said.try_into().unwrap();
    let mut wrong = right;
    wrong[31] ^= 1;
    let served = Served::with_token("press", Some(token));
    for token in [NO_TOKEN, wrong] {
        let mut viewer = served.stranger();
        viewer.say(&FromViewer::Hello(ViewerHello::new(token)));
        assert_eq!(viewer.until_closed(), Some(ToViewer::Refused(Refusal::new(RefusalCause::Token))));
    }
    let mut viewer = served.stranger();
    viewer.say(&FromViewer::Hello(ViewerHello::new(right)));
    viewer.wait_for("a welcome", |message| matches!(message, ToViewer::Welcome(_)).then_some(()));
    served.end();
}

#[test]
fn who_does_not_begin_with_a_hello_is_shown_the_door() {
    let served = Served::new("press");
    let mut hello = [0; 64];
    let n = encode_stream(&FromViewer::Hello(ViewerHello::new(NO_TOKEN)), &mut hello).unwrap();
    // a web page that posts a good hello behind the header that its browser writes
    let post = [b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n\0", &hello[..n]].concat();
    let mut page = served.stranger();
    page.say_bytes(&post);
    assert_eq!(page.until_closed(), Some(ToViewer::Refused(Refusal::new(RefusalCause::Garbage))));

    let mut eager = served.stranger();
    eager.say(&FromViewer::Ping(1));
    assert_eq!(eager.until_closed(), Some(ToViewer::Refused(Refusal::new(RefusalCause::Order))));

    let mut twice = served.viewer();
    twice.say(&FromViewer::Hello(ViewerHello::new(NO_TOKEN)));
    assert_eq!(twice.until_closed(), Some(ToViewer::Refused(Refusal::new(RefusalCause::Order))));

    let mut silent = served.stranger();
    assert_eq!(silent.until_closed(), Some(ToViewer::Refused(Refusal::new(RefusalCause::Silent))));
    served.end();
}

#[test]
fn one_viewer_too_many_is_told_so_and_finds_room_when_one_goes() {
    let served = Served::new("press");
    let mut viewers: Vec<TestViewer> = (0..VIEWERS_MAX).map(|_| served.viewer()).collect();
    let mut late = served.stranger();
    late.say(&FromViewer::Hello(ViewerHello::new(NO_TOKEN)));
    assert_eq!(late.until_closed(), Some(ToViewer::Refused(Refusal::new(RefusalCause::TooMany))));
    viewers.pop();
    viewers[0].settle();
    viewers[0].settle();
    viewers.push(served.viewer());
    viewers.iter_mut().for_each(TestViewer::settle);
    served.end();
}

#[test]
fn snapshots_come_at_the_asked_decimation_and_are_what_was_recorded() {
    let mut served = Served::new("press-twist-slide");
    let mut viewer = served.viewer();
    viewer.subscribe(7, 0, 0);
    let mut seen = Vec::new();
    while seen.len() < 400 {
        seen.push(served.tick_until(&mut viewer, "a snapshot", snapshot));
    }
    let rig = served.end();
    assert!(seen.windows(2).all(|two| two[1].tick / 7 > two[0].tick / 7), "one a multiple at most");
    // ticks pass while a snapshot is on its way, but none is left out
    assert!(seen.windows(2).all(|two| two[1].tick - two[0].tick == 7), "none is left out");
    let ticks: HashMap<u64, &TickRecord> = rig.ticks.iter().map(|tick| (tick.tick, tick)).collect();
    for snapshot in &seen {
        let tick = ticks[&snapshot.tick];
        assert_eq!((snapshot.contact_force, snapshot.contact_torque), (tick.contact_force, tick.contact_torque));
        assert_eq!((snapshot.flags, snapshot.depth, snapshot.t_us), (tick.flags, tick.depth, tick.t_us));
        let sum = snapshot.patches.iter().fold(Vec3::ZERO, |sum, patch| sum + Vec3::from_array(patch.force));
        assert!((sum - Vec3::from_array(tick.contact_force)).length() <= 1.0e-5 * (1.0 + sum.length()), "{snapshot:?}");
        assert!(snapshot.patches.iter().all(|patch| patch.stick_radius <= patch.radius && patch.depth <= snapshot.depth));
    }
    assert!(seen.iter().any(|s| !s.patches.is_empty()) && seen.iter().any(|s| s.patches.is_empty()));
    let pressed = seen.iter().max_by(|a, b| a.depth.total_cmp(&b.depth)).expect("400 of them");
    assert!(pressed.depth > 3.0e-4, "the hand presses");
    assert_eq!((pressed.mode, pressed.output, pressed.tier), (Mode::Force, OutputState::Open, Tier::Bristle));
    assert!((pressed.position[2] - (0.12 - pressed.depth)).abs() < 1.0e-6);
    assert_eq!(length(pressed.sent_force), length(ticks[&pressed.tick].force));
}

#[test]
fn the_surface_under_the_probe_goes_down_with_it_and_the_base_stands() {
    let mut served = Served::new("press");
    let mut viewer = served.viewer();
    // 600 points: three messages each way; the first under the probe, the last at the base
    let points: Vec<[f32; 3]> = (0..600).map(|i| [0.0, 0.0, 0.1 * (1.0 - i as f32 / 599.0)]).collect();
    viewer.say(&FromViewer::RestBegin(RestBegin { count: 600 }));
    for (i, some) in points.chunks(256).enumerate() {
        let points = some.iter().copied().collect();
        viewer.say(&FromViewer::RestPoints(RestPoints { offset: 256 * i as u32, points }));
    }
    viewer
        .wait_for("all points", |m| matches!(m, ToViewer::Rest(state) if state.have == 600 && state.why.is_none()).then_some(()));
    served.press();
    // who looks without a surface costs none
    viewer.subscribe(5, 0, 1);
    let counted = |statistics: &Statistics| [statistics.surfaces, statistics.passes, statistics.points, statistics.behind];
    let seen = |message: &ToViewer| statistics(message).filter(|told| told.sent > 20);
    assert_eq!(counted(&served.tick_until(&mut viewer, "statistics", seen)), [0; 4]);
    viewer.subscribe(5, 1, 1);
    let blocks: Vec<_> = [0, 256, 512]
        .map(|offset| {
            served.tick_until(&mut viewer, "a block", |message| match message {
                ToViewer::Surface(block) if block.offset == offset => Some(block.clone()),
                _ => None,
            })
        })
        .into();
    assert!(blocks.iter().all(|block| (block.tick, block.of) == (blocks[0].tick, 600)));
    let told = served.tick_until(&mut viewer, "statistics", |m| statistics(m).filter(|told| told.surfaces > 0));
    assert_eq!((told.passes, told.points), (told.surfaces, 600 * told.surfaces), "{told:?}");
    let moved: Vec<[f32; 3]> = blocks.iter().flat_map(|block| block.displacements().collect::<Vec<_>>()).collect();
    let rig = served.end();
    let tick = rig.ticks.iter().find(|tick| tick.tick == blocks[0].tick).unwrap();
    assert!(tick.depth > 1.0e-4, "{} m", tick.depth);
    assert!((moved[0][2] + tick.depth).abs() < 1.0e-6 + blocks[0].step, "{:?} at depth {}", moved[0], tick.depth);
    assert_eq!((moved.len(), moved[599]), (600, [0.0; 3]));
}

#[test]
fn a_cut_upload_goes_on_and_the_scene_takes_over_behind_a_closed_output() {
    let mut served = Served::new("press");
    let scene = hard_cube();
    let whole = file(&scene);
    let digest = scene_file::digest(&whole);
    let mut first = served.viewer();
    assert_eq!(first.upload(&whole, digest, whole.len() / 2) as usize, whole.len() / 2);
    let mut viewer = served.viewer();
    assert_eq!(served.ask(&mut viewer, Wish::Activate(digest)), Err(Denial::NoModel));
    drop(first);
    assert_eq!(viewer.upload(&whole, digest, 0) as usize, whole.len() / 2, "what came before the cut is still there");
    viewer.upload(&whole, digest, whole.len());

    served.press();
    let before = *served.rig.last();
    let number = viewer.ask(Wish::Activate(digest));
    let now = served.tick_until(&mut viewer, "the scene", |message| match message {
        ToViewer::Scene(scene) if scene.digest == digest => Some(*scene),
        _ => None,
    });
    served.tick_until(&mut viewer, "an answer", |m| (*m == ToViewer::Done(number)).then_some(()));
    let changed = served.rig.last().tick;
    assert_eq!((now.digest, now.length as usize), (digest, whole.len()));
    served.lift();
    served.press();
    let rig = served.end();
    let since: Vec<&TickRecord> = rig.ticks.iter().filter(|tick| tick.tick > before.tick && tick.tick < changed + 500).collect();
    let steps = since.windows(2).map(|two| (length(two[1].force) - length(two[0].force)).abs());
    let largest = steps.fold(0.0, f32::max);
    let strongest = since.iter().map(|tick| length(tick.force)).fold(0.0, f32::max);
    assert!(largest <= 1.01 * strongest / FADE_TICKS as f32, "{largest} N a tick of {strongest} N");
    let opened = rig.ticks.iter().find(|t| t.tick > changed && t.flags & (flags::CLOSED | flags::NO_POSE) == 0).unwrap();
    assert!(length(opened.contact_force) < SMALL_FORCE, "opened at {} N", length(opened.contact_force));
    assert_eq!((rig.summary().fault, rig.faults.len()), (None, 0));
    assert_replays(&rig, &[ball_on_cube(), scene]);
}

#[test]
fn parameters_change_between_two_ticks() {
    let mut served = Served::new("slide");
    let mut viewer = served.viewer();
    served.press();
    let slippery = Tuning { friction_static: 0.05, friction_dynamic: 0.05, ..Tuning::of(&ball_on_cube()) };
    assert_eq!(served.ask(&mut viewer, Wish::Tune(slippery)), Ok(()));
    let tuned = served.rig.last().tick;
    let bad = Tuning { friction_dynamic: -1.0, ..slippery };
    let number = viewer.ask(Wish::Tune(bad));
    let words = served.tick_until(&mut viewer, "a denial", |message| match message {
        ToViewer::Denied(denied) if denied.number == number => Some(denied.to_string()),
        _ => None,
    });
    assert!(words.contains("friction") && words.contains("-1"), "{words}");
    (0..3000).for_each(|_| served.rig.tick());
    let rig = served.end();
    // sideways force is at most friction times the normal force
    let share = |tick: &TickRecord| tick.contact_force[0].hypot(tick.contact_force[1]) / tick.contact_force[2].max(0.5);
    let most = |from, to| rig.ticks.iter().filter(|t| (from..to).contains(&t.tick)).map(share).fold(0.0, f32::max);
    assert!(most(tuned + 50, u64::MAX) < 0.06, "{}", most(tuned + 50, u64::MAX));
    assert_replays(&rig, &[ball_on_cube()]);
}

#[test]
fn an_emergency_stop_brakes_the_device_at_once_and_holds_until_re_armed() {
    let mut served = Served::new("press");
    let (mut viewer, mut other) = (served.viewer(), served.viewer());
    served.press();
    let stopped = {
        let number = viewer.ask(Wish::EStop);
        served.tick_until(&mut viewer, "an answer", |m| (*m == ToViewer::Done(number)).then_some(()));
        served.tick_until(&mut other, "word of it", event(What::EmergencyStop))
    };
    (0..1000).for_each(|_| served.rig.tick());
    assert_eq!(served.rig.far().device.mode(), Mode::Brake);
    let after: Vec<_> = served.rig.ticks.iter().filter(|tick| tick.tick >= stopped).collect();
    assert!(after.iter().all(|tick| tick.flags & flags::CLOSED != 0 && length(tick.force) == 0.0));
    other.subscribe(1, 0, 0);
    let seen = served.tick_until(&mut other, "a snapshot", snapshot);
    assert_eq!((seen.output, seen.mode), (OutputState::Stopped, Mode::Brake));
    // it holds whatever happens to the link
    served.rig.far().cut = true;
    assert!(served.rig.until(500, |rig| !rig.faults.is_empty()));
    served.rig.reopen();
    (0..500).for_each(|_| served.rig.tick());
    assert_eq!(served.rig.far().device.mode(), Mode::Brake, "a new link brings no forces");
    assert_eq!(served.ask(&mut viewer, Wish::Rearm), Ok(()));
    assert_eq!(served.ask(&mut viewer, Wish::Rearm), Err(Denial::NotStopped));
    let armed = served.rig.last().tick;
    served.press();
    let rig = served.end();
    let opened = rig.ticks.iter().find(|t| t.tick > armed && t.flags & flags::CLOSED == 0).unwrap();
    assert!(length(opened.contact_force) < SMALL_FORCE);
    assert!(opened.tick - armed >= u64::from(CALM_TICKS));
    assert_replays(&rig, &[ball_on_cube()]);
}

#[test]
fn a_frozen_core_fades_out_and_comes_back_from_a_small_force() {
    let mut served = Served::new("press");
    let mut viewer = served.viewer();
    served.press();
    let force = length(served.rig.last().force);
    assert_eq!(served.ask(&mut viewer, Wish::Freeze(true)), Ok(()));
    assert_eq!(served.ask(&mut viewer, Wish::Tare), Err(Denial::Frozen));
    let frozen = served.rig.last().tick;
    (0..300).for_each(|_| served.rig.tick());
    viewer.subscribe(1, 0, 0);
    assert_eq!(served.tick_until(&mut viewer, "a snapshot", snapshot).output, OutputState::Frozen);
    assert_eq!(served.ask(&mut viewer, Wish::Freeze(false)), Ok(()));
    let resumed = served.rig.last().tick;
    served.lift();
    served.press();
    let rig = served.end();
    let stood: Vec<_> = rig.ticks.iter().filter(|t| (frozen + 1..resumed - 50).contains(&t.tick)).collect();
    assert!(stood.iter().all(|tick| tick.flags & flags::NO_POSE != 0), "the core stands");
    let faded = stood.iter().skip((HOLD_TICKS + FADE_TICKS) as usize);
    assert!(faded.clone().count() > 200 && faded.clone().all(|tick| length(tick.force) == 0.0));
    let steps = rig.ticks.windows(2).map(|two| length(two[0].force) - length(two[1].force));
    assert!(steps.fold(0.0, f32::max) <= 1.2 * force / FADE_TICKS as f32, "no step");
    let opened = rig.ticks.iter().find(|t| t.tick > resumed && t.flags & flags::CLOSED == 0).unwrap();
    assert!(length(opened.contact_force) < SMALL_FORCE);
    assert_eq!(rig.summary().fault, None);
    assert_replays(&rig, &[ball_on_cube()]);
}

#[test]
fn tare_brings_the_probe_to_where_the_scene_starts_it() {
    let mut served = Served::new("slide");
    let mut viewer = served.viewer();
    served.press();
    assert_eq!(served.ask(&mut viewer, Wish::Tare), Err(Denial::InContact));
    // on the way down, away from where the device's origin is
    let hovers = |rig: &Rig| rig.last().flags == 0 && rig.last().regions == 0 && length(rig.last().position) > 2.0e-3;
    assert!(served.rig.until(20_000, hovers));
    let handle = Vec3::from_array(served.rig.last().position);
    viewer.subscribe(1, 0, 0);
    let number = viewer.ask(Wish::Tare);
    let tared = served.tick_until(&mut viewer, "word of it", event(What::Tared));
    served.tick_until(&mut viewer, "an answer", |m| (*m == ToViewer::Done(number)).then_some(()));
    let seen = served.tick_until(&mut viewer, "a snapshot", |m| snapshot(m).filter(|s| s.tick > tared));
    let start = Vec3::from_array(ball_on_cube().place.p_wd);
    let moved_since = 0.2 * 0.3;
    assert!(
        (Vec3::from_array(seen.position) - start).length() < moved_since,
        "{:?} from {start}, handle at {handle}",
        seen.position
    );
    let rig = served.end();
    let at = rig.ticks.iter().find(|t| t.tick == seen.tick).unwrap();
    let before = rig.ticks.iter().rfind(|t| t.tick < tared && t.flags & flags::NO_POSE == 0).unwrap();
    let expected = start + Vec3::from_array(at.position) - Vec3::from_array(before.position);
    assert!((Vec3::from_array(seen.position) - expected).length() < 1.0e-6);
    assert_eq!(rig.summary().fault, None);
    assert_replays(&rig, &[ball_on_cube()]);
}

#[test]
fn what_cannot_be_done_is_denied_with_its_reason() {
    let mut served = Served::new("press");
    let mut viewer = served.viewer();
    assert_eq!(served.ask(&mut viewer, Wish::Activate(1)), Err(Denial::NoModel));
    assert_eq!(served.ask(&mut viewer, Wish::Record(false)), Err(Denial::NotRecording));
    served.press();
    assert_eq!(served.ask(&mut viewer, Wish::Rearm), Err(Denial::NotStopped));
    // bytes that are not what they were announced as; a scene that is none
    let whole = file(&hard_cube());
    viewer.upload(&whole, 7, whole.len());
    assert_eq!(served.ask(&mut viewer, Wish::Activate(7)), Err(Denial::Digest));
    assert_eq!(served.ask(&mut viewer, Wish::Activate(7)), Err(Denial::NoModel), "forgotten");
    let bad = BakedScene { object: ObjectShape::Box { size: [-0.1; 3] }, ..ball_on_cube() };
    let digest = viewer.upload_scene(&bad);
    assert_eq!(served.ask(&mut viewer, Wish::Activate(digest)), Err(Denial::Scene));
    // chunks nobody announced, points nobody announced, too many points, too long a model
    viewer.say(&FromViewer::UploadChunk(UploadChunk { digest: 99, offset: 0, bytes: heapless::Vec::new() }));
    let upload = |m: &ToViewer| if let ToViewer::Upload(state) = m { state.why } else { None };
    assert_eq!(viewer.wait_for("a state", upload), Denial::NoModel);
    viewer.say(&FromViewer::UploadBegin(UploadBegin { digest: 99, length: u32::MAX }));
    assert_eq!(viewer.wait_for("a state", upload), Denial::TooLarge);
    let rest = |m: &ToViewer| if let ToViewer::Rest(state) = m { state.why } else { None };
    viewer.say(&FromViewer::RestBegin(RestBegin { count: u32::MAX }));
    assert_eq!(viewer.wait_for("a state", rest), Denial::TooLarge);
    let point = |x| RestPoints { offset: 0, points: heapless::Vec::from_slice(&[[x, 0.0, 0.0]]).unwrap() };
    viewer.say(&FromViewer::RestPoints(point(0.0)));
    assert_eq!(viewer.wait_for("a state", rest), Denial::OutOfOrder);
    viewer.say(&FromViewer::RestBegin(RestBegin { count: 1 }));
    viewer.say(&FromViewer::RestPoints(point(f32::NAN)));
    assert_eq!(viewer.wait_for("a state", rest), Denial::Value);
    let rig = served.end();
    assert_eq!(rig.summary().fault, None);
}

#[test]
fn the_running_scene_can_be_downloaded_and_a_recording_taken_along() {
    let mut served = Served::new("press");
    let mut viewer = served.viewer();
    let number = viewer.ask(Wish::Download);
    let mut got = Vec::new();
    viewer.wait_for("the file", |message| match message {
        ToViewer::SceneBytes(piece) => {
            assert_eq!(piece.offset as usize, got.len());
            got.extend_from_slice(&piece.bytes);
            None
        }
        done => (*done == ToViewer::Done(number)).then_some(()),
    });
    assert_eq!(got, file(&ball_on_cube()));

    viewer.ask(Wish::Record(true));
    let (mut bytes, mut ended) = (Vec::new(), None);
    // more than a whole press, the first rest among it
    served.tick_until(&mut viewer, "bytes", |message| {
        take_bytes(message, &mut bytes);
        (bytes.len() > 400_000).then_some(())
    });
    let second = viewer.ask(Wish::Record(true));
    let number = viewer.ask(Wish::Record(false));
    served.tick_until(&mut viewer, "the last bytes", |message| {
        take_bytes(message, &mut bytes);
        if let ToViewer::Denied(denied) = message {
            ended = Some((denied.number, denied.why));
        }
        (*message == ToViewer::Done(number)).then_some(())
    });
    assert_eq!(ended, Some((second, Denial::Recording)));
    let rig = served.end();
    let records: Vec<Record<'_>> = RecordReader::new(bytes.leak()).map(Result::unwrap).collect();
    assert!(matches!(records[0], Record::Header(header) if header.scene_digest == scene_file::digest(&file(&ball_on_cube()))));
    let ticks: Vec<TickRecord> =
        records.iter().filter_map(|r| if let Record::Tick(tick) = r { Some(*tick) } else { None }).collect();
    assert!(ticks.len() >= 1500, "{}", ticks.len());
    let recorded: HashMap<u64, &TickRecord> = rig.ticks.iter().map(|tick| (tick.tick, tick)).collect();
    assert!(ticks.iter().all(|tick| recorded[&tick.tick] == tick) && ticks.windows(2).all(|two| two[1].tick == two[0].tick + 1));
    assert!(replay(&records, &[ball_on_cube()]) > 500, "from its first rest on it is computed again");
}

/// What a tick may spend, as viewers are told it: picks the message that says `work`.
fn may_spend(work: Option<u32>) -> impl FnMut(&ToViewer) -> Option<()> {
    move |message| matches!(message, ToViewer::Device(hello) if hello.work == work).then_some(())
}

/// Less than bristles cost, more than tier `point` does.
const LITTLE: u32 = 13_000;

/// Asks for a work budget and ticks until it is told, done, and has made a tick.
fn limit(served: &mut Served, viewer: &mut TestViewer, budget: WorkBudget, holds: Option<u32>) {
    let number = viewer.ask(Wish::Budget(budget));
    served.tick_until(viewer, "what a tick may spend", may_spend(holds));
    served.tick_until(viewer, "an answer", |m| (*m == ToViewer::Done(number)).then_some(()));
    served.rig.tick();
}

/// The tier of the last tick, and whether it is less than was asked for.
fn tier(served: &Served) -> (Tier, bool) {
    let last = served.rig.last();
    (last.tier, last.flags & haptor_contact::Flags::TIER_LOWERED.0 != 0)
}

/// The budgets that the recording says were set, one after the other.
fn budgets(rig: &Rig) -> Vec<Option<u32>> {
    let told = |record: &Record<'_>| if let Record::Tuning(tuning) = record { Some(tuning.work) } else { None };
    let mut works: Vec<_> = rig.records.iter().filter_map(told).collect();
    works.dedup();
    works
}

#[test]
fn a_work_budget_holds_from_the_next_tick_on() {
    let mut served = Served::new("press-twist-slide");
    let mut viewer = served.viewer();
    served.press();
    assert_eq!(tier(&served), (Tier::Bristle, false));
    limit(&mut served, &mut viewer, WorkBudget::Work(LITTLE), Some(LITTLE));
    assert_eq!(tier(&served), (Tier::Point, true));
    limit(&mut served, &mut viewer, WorkBudget::Off, None);
    assert_eq!(tier(&served), (Tier::Bristle, false), "no limit is the highest rung at once");
    let number = viewer.ask(Wish::Budget(WorkBudget::Work(1)));
    let words = served.tick_until(&mut viewer, "a denial", |message| match message {
        ToViewer::Denied(denied) if denied.number == number => Some(denied.to_string()),
        _ => None,
    });
    assert!(words.contains("model.work is 1") && words.contains("1e4 to 1e9"), "{words}");
    viewer.ask(Wish::Budget(WorkBudget::Auto));
    let measured = |message: &ToViewer| if let ToViewer::Device(hello) = message { hello.work } else { None };
    let work = served.tick_until(&mut viewer, "a measured budget", measured);
    assert!((haptor_contact::MIN_WORK..=haptor_contact::MAX_WORK).contains(&work), "{work}");
    (0..1_000).for_each(|_| served.rig.tick());
    let rig = served.end();
    assert_eq!(budgets(&rig), [None, Some(LITTLE), None, Some(work)], "every change is recorded");
    assert_replays(&rig, &[ball_on_cube()]);
}

#[test]
fn a_work_budget_holds_for_the_scenes_that_viewers_bring_too() {
    let mut served = Served::new("press-twist-slide");
    let mut viewer = served.viewer();
    served.press();
    limit(&mut served, &mut viewer, WorkBudget::Work(LITTLE), Some(LITTLE));
    let scene = BakedScene { work: Some(1_000_000), ..hard_cube() };
    let whole = file(&scene);
    let digest = scene_file::digest(&whole);
    viewer.upload(&whole, digest, whole.len());
    assert_eq!(served.ask(&mut viewer, Wish::Activate(digest)), Ok(()));
    let touches = |t: &TickRecord| t.regions > 0 && t.flags & (flags::CLOSED | flags::NO_POSE) == 0;
    assert!(served.rig.until(20_000, |rig| rig.ticks.last().is_some_and(touches)), "the hand presses again");
    assert_eq!(tier(&served), (Tier::Point, true), "whatever the scene says");
    // a tuning's own budget is that of the scene which it tunes
    assert_eq!(served.ask(&mut viewer, Wish::Tune(Tuning { work: None, ..Tuning::of(&scene) })), Ok(()));
    served.rig.tick();
    assert_eq!(tier(&served), (Tier::Bristle, false));
    // and the scene's word is the rule again
    limit(&mut served, &mut viewer, WorkBudget::Scene, Some(1_000_000));
    (0..100).for_each(|_| served.rig.tick());
    let rig = served.end();
    assert_eq!(budgets(&rig), [None, Some(LITTLE), None, Some(1_000_000)], "every change is recorded");
    assert_replays(&rig, &[ball_on_cube(), scene]);
}

/// Bytes of a recording follow each other.
fn take_bytes(message: &ToViewer, bytes: &mut Vec<u8>) {
    if let ToViewer::RecordBytes(piece) = message {
        assert_eq!(piece.offset, bytes.len() as u64);
        bytes.extend_from_slice(&piece.bytes);
    }
}

#[test]
fn statistics_count_what_the_session_counts_and_the_end_is_told() {
    let mut served = Served::new("press");
    let mut viewer = served.viewer();
    served.press();
    viewer.subscribe(1, 0, 1);
    let told = served.tick_until(&mut viewer, "statistics of the press", |m| statistics(m).filter(|s| s.session.ticks > 300));
    assert_eq!((told.viewers, told.rejected, told.session.late, told.session.fault), (1, 0, 0, None));
    assert!(told.session.step_ns.max > 0 || told.session.wake_ns.max == 0);
    let rig = served.end();
    let last = viewer.until_closed();
    assert_eq!(last, Some(ToViewer::End(rig.summary())));
}

/// Numbers that look random, the same every time: a linear congruential generator, Knuth's constants.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }
}

/// Good messages of every kind, as bytes.
fn good_messages() -> Vec<Vec<u8>> {
    let whole = file(&hard_cube());
    let digest = scene_file::digest(&whole);
    let wishes =
        [Wish::Activate(digest), Wish::Freeze(false), Wish::Rearm, Wish::Record(true), Wish::Record(false), Wish::Download];
    let mut messages = vec![
        FromViewer::Subscribe(haptor_wire::Subscription { every: 1, surface: 1, statistics_ms: 1 }),
        FromViewer::UploadBegin(UploadBegin { digest: 3, length: 1 << 20 }),
        FromViewer::UploadChunk(UploadChunk { digest: 3, offset: 0, bytes: whole.iter().copied().take(600).collect() }),
        FromViewer::RestBegin(RestBegin { count: 100 }),
        FromViewer::RestPoints(RestPoints { offset: 0, points: (0..100).map(|i| [0.0, 0.0, 1.0e-3 * i as f32]).collect() }),
        FromViewer::Ping(7),
    ];
    // requests that change nothing in a session that is neither frozen nor stopped
    messages.extend(wishes.into_iter().skip(1).map(|what| FromViewer::Ask(haptor_wire::Ask { number: 1, what })));
    messages
        .iter()
        .map(|message| {
            let mut frame = [0; 8192];
            let n = encode_stream(message, &mut frame).unwrap();
            frame[..n].to_vec()
        })
        .collect()
}

/// Bytes that no viewer sends: noise, good frames with flipped bits, frames run together, cut, repeated.
fn hostile(noise: &mut Noise, messages: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for _ in 0..20 {
        let mut frame = messages[noise.next() as usize % messages.len()].clone();
        match noise.next() % 6 {
            0 => frame = (0..noise.next() % 400).map(|_| noise.next() as u8).collect(),
            1 => {
                let at = noise.next() as usize % frame.len();
                frame[at] ^= 1 << (noise.next() % 8);
            }
            2 => frame.truncate(noise.next() as usize % frame.len()),
            3 => drop(frame.pop()),
            4 => frame.extend_from_within(..),
            _ => {}
        }
        bytes.extend(frame);
    }
    bytes
}

#[test]
fn nonsense_never_reaches_the_session() {
    let messages = good_messages();
    let mut served = Served::new("press-twist-slide");
    let mut noise = Noise(1);
    let (mut in_greeting, mut let_in) = (0, 0);
    for round in 0..150 {
        let mut viewer = if round % 3 == 0 { served.stranger() } else { served.viewer() };
        for _ in 0..4 {
            viewer.say_bytes(&hostile(&mut noise, &messages));
            (0..5).for_each(|_| served.rig.tick());
            viewer.hear();
        }
        if round % 3 == 0 {
            in_greeting += u32::from(matches!(viewer.until_closed(), Some(ToViewer::Refused(_))));
        } else {
            let_in += 1;
        }
    }
    assert_eq!((in_greeting, let_in), (50, 100), "who begins with nonsense is refused");
    // a good viewer is served as ever
    let mut viewer = served.viewer();
    viewer.subscribe(1, 0, 0);
    served.tick_until(&mut viewer, "a snapshot", snapshot);
    let rig = served.end();
    let same = alone("press-twist-slide", rig.ticks.len());
    // the recordings that were asked for put the core at rest once, without contact: nothing else differs
    assert_eq!(rig.summary().fault, None);
    assert!(
        rig.ticks.iter().zip(&same).all(|(a, b)| a.flags == b.flags && a.tick == b.tick && a.contact_force == b.contact_force)
    );
}

#[test]
fn a_slow_reader_loses_snapshots_which_are_counted_and_nobody_else_does() {
    let mut served = Served::on_unix("press-twist-slide");
    let (mut slow, mut quick) = (served.viewer(), served.viewer());
    // large surfaces fill what lies between: 4,000 points are 25 kB
    slow.say(&FromViewer::RestBegin(RestBegin { count: 4000 }));
    for i in 0..16 {
        let points = (0..250).map(|k| [0.0, 0.0, 2.5e-5 * (250 * i + k) as f32]).collect();
        slow.say(&FromViewer::RestPoints(RestPoints { offset: 250 * i, points }));
    }
    served.press();
    slow.subscribe(1, 10, 0);
    quick.subscribe(1, 0, 0);
    let (mut shown, mut last) = (0_u64, None);
    while shown < 2_500 {
        let tick = served.tick_until(&mut quick, "a snapshot", |m| snapshot(m).map(|s| s.tick));
        assert!(last.is_none_or(|last| tick == last + 1), "the quick one loses nothing: {tick} after {last:?}");
        (shown, last) = (shown + 1, Some(tick));
        if shown % 250 == 0 {
            // it is there, and takes a little
            slow.hear();
        }
    }
    slow.say(&FromViewer::Subscribe(haptor_wire::Subscription { every: 0, surface: 0, statistics_ms: 10 }));
    let mut seen = slow.heard.iter().filter(|message| snapshot(message).is_some()).count() as u64;
    slow.heard.clear();
    let told: Statistics = served.tick_until(&mut slow, "statistics", |message| match message {
        ToViewer::Statistics(statistics) => Some(*statistics),
        message => {
            seen += u64::from(snapshot(message).is_some());
            None
        }
    });
    assert!(told.dropped > 500 && told.sent > 500, "{told:?}");
    assert_eq!((told.sent, told.missed), (seen, 0), "what was sent came, and the server kept up");
    assert!(told.sent + told.dropped >= shown, "every tick is accounted for");
    let rig = served.end();
    assert!(rig.ticks == alone("press-twist-slide", rig.ticks.len()), "the session is the same, tick by tick");
}

/// Attach, look, leave: every twenty ticks, two hundred times.
#[test]
fn viewers_that_come_and_go_change_nothing_and_cost_no_call_to_the_allocator() {
    let mut served = Served::new("press-twist-slide");
    served.press();
    for round in 0..200 {
        let mut viewer = served.viewer();
        viewer.subscribe(1 + round % 3, 0, 1);
        for _ in 0..20 {
            let ((), calls) = counted(|| served.rig.control.tick());
            assert_eq!(calls, 0, "round {round}");
            served.rig.collect();
        }
        if round % 2 == 0 {
            viewer.wait_for("a snapshot", snapshot);
        }
    }
    let rig = served.end();
    assert_eq!((rig.summary().fault, rig.summary().late), (None, 0));
    assert!(rig.ticks == alone("press-twist-slide", rig.ticks.len()), "the session is the same, tick by tick");
}

/// Computes a rig's session again from what it recorded.
fn assert_replays(rig: &Rig, scenes: &[BakedScene]) {
    assert!(replay(&rig.records, scenes) > 1000);
}

/// Computes ticks again by the rule of the recording and compares, bit by bit; yields how many.
fn replay(records: &[Record<'_>], scenes: &[BakedScene]) -> usize {
    let scenes: HashMap<u64, Scene> =
        scenes.iter().map(|baked| (scene_file::digest(&file(baked)), Scene::new(baked).unwrap())).collect();
    let first = scene_file::digest(&file(&ball_on_cube()));
    let mut scene = &scenes[&first];
    let (mut core, mut last, mut compared): (OwnedEngine, Option<Option<u64>>, _) = (scene.engine().unwrap(), None, 0);
    for record in records {
        match record {
            Record::Header(header) => {
                scene = &scenes[&header.scene_digest];
                (core, last) = (scene.engine().unwrap(), None);
            }
            Record::Device(hello) => core.fit(&device(hello)).unwrap(),
            Record::Tuning(tuning) => core.tune(&scene.tuned(tuning).unwrap()),
            Record::Place(place) => core.place(&Placed::new(place).unwrap()),
            Record::Rest => {
                core.rest();
                last = Some(None);
            }
            Record::Tick(tick) if tick.flags & flags::NO_POSE == 0 => {
                let Some(before) = &mut last else { continue };
                let since = before.map_or(1, |before: u64| tick.tick - before);
                *before = Some(tick.tick);
                let [w, x, y, z] = tick.rotation;
                let x_dh = Pose::new(Vec3::from_array(tick.position), Quat::from_xyzw(x, y, z, w).normalize());
                let felt = core.step(&x_dh, (since as f64 / 1000.0) as f32);
                assert_eq!(felt.contact_force, tick.contact_force, "tick {}", tick.tick);
                assert_eq!(felt.contact_torque, tick.contact_torque, "tick {}", tick.tick);
                assert_eq!((felt.regions, felt.depth), (tick.regions, tick.depth), "tick {}", tick.tick);
                if tick.flags & (flags::HELD | flags::CLOSED) == 0 {
                    assert_eq!(felt.wrench.force.to_array(), tick.force, "tick {}", tick.tick);
                }
                compared += 1;
            }
            _ => {}
        }
    }
    compared
}

fn device(hello: &haptor_wire::SessionHello) -> DeviceHello {
    DeviceHello {
        version: PROTOCOL_VERSION,
        schema: SCHEMA_HASH,
        name: hello.device_name,
        serial: hello.device_serial,
        max_force_un: hello.max_force_un,
        max_torque_unm: hello.max_torque_unm,
        watchdog_ticks: 0,
    }
}
