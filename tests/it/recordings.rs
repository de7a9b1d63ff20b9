//! What the real-time thread records comes out again to the bit: with faults, with a virtual coupling, begun in the middle; and cut or flipped anywhere it proves
//! what is whole and lies about nothing.

use std::sync::atomic::Ordering;

use haptor_engine::replay::{Verdict, verify};
use haptor_host::recorder::origin::{Origin, append};
use haptor_wire::sections::{SECTION_OVERHEAD, encode_section};
use haptor_wire::{BakedScene, Coupling, Record, RecordReader, VirtualCoupling, flags, scene_file};

use crate::host_rig::{RATE_HZ, Rig, ball_on_cube};
use crate::support::noise::noise;

/// Bytes of data behind the scene that no build knows: the scene then has several chunks.
const MORE: usize = 5000;

/// The file of a scene.
fn file(scene: &BakedScene) -> Vec<u8> {
    let mut file = vec![0; scene_file::FILE_MAX];
    let length = scene_file::encode_file(scene, &mut file).unwrap();
    file.truncate(length);
    file.resize(length + MORE + SECTION_OVERHEAD, 0);
    encode_section(99, &[7; MORE], &mut file[length..]).unwrap();
    file
}

/// A recording as the recorder writes it.
fn recording(scene: &BakedScene, records: &[Record<'static>]) -> Vec<u8> {
    let mut frames = Origin::new(RATE_HZ, file(scene).into()).frames().unwrap();
    records.iter().for_each(|record| append(&mut frames, record).unwrap());
    frames
}

fn verdict(file: &[u8]) -> Verdict {
    verify(&mut file.to_vec(), |_| ()).unwrap()
}

/// Ticks in which the core ran.
fn stepped<'a>(records: impl IntoIterator<Item = &'a Record<'static>>) -> u64 {
    let ran = |record: &&Record<'_>| matches!(record, Record::Tick(tick) if tick.flags & flags::NO_POSE == 0);
    records.into_iter().filter(ran).count() as u64
}

fn session(scene: &BakedScene, ticks: u32) -> Rig {
    let mut rig = Rig::on(scene, "press-twist-slide", None, |cable| Box::new(cable));
    rig.until(ticks, |_| false);
    rig
}

#[test]
fn a_session_comes_out_again_with_its_faults_and_what_was_sent() {
    let virtually = BakedScene { coupling: Coupling::Virtual(VirtualCoupling::DEVICE_S_OWN), ..ball_on_cube() };
    for scene in [ball_on_cube(), virtually] {
        let mut rig = session(&scene, 1500);
        rig.far().stall(60_000);
        rig.until(1500, |_| false);
        assert!(!rig.faults.is_empty() && rig.ticks.iter().any(|tick| tick.regions > 0));
        let verdict = verdict(&recording(&scene, &rig.records));
        assert_eq!((verdict.first, verdict.counts.unverifiable, verdict.no_scene), (None, 0, None));
        assert_eq!(verdict.counts.verified, stepped(&rig.records));
        assert!(verdict.counts.idle > 0, "the stall");
    }
}

#[test]
fn a_recording_begun_in_the_middle_is_verified_from_the_first_rest_on() {
    let scene = ball_on_cube();
    let mut rig = session(&scene, 100);
    assert!(rig.until(4000, |rig| rig.last().regions > 0), "the hand presses");
    let begun = rig.records.len();
    rig.rest_wanted().store(true, Ordering::Relaxed);
    let rested = |rig: &Rig| rig.records[begun..].iter().any(|record| matches!(record, Record::Rest));
    assert!(rig.until(20_000, rested), "the hand comes out");
    assert!(!rig.rest_wanted().load(Ordering::Relaxed), "once");
    rig.until(2000, |_| false);

    let records = &rig.records[begun..];
    let rest = records.iter().position(|record| matches!(record, Record::Rest)).unwrap();
    let before = records[..rest].iter().rev().find_map(|record| if let Record::Tick(tick) = record { Some(tick) } else { None });
    assert_eq!(before.unwrap().regions, 0, "nobody feels it");
    let verdict = verdict(&recording(&scene, records));
    assert_eq!((verdict.first, verdict.counts.verified), (None, stepped(&records[rest..])));
    assert_eq!(verdict.counts.unverifiable, stepped(&records[..rest]));
}

#[test]
fn cut_anywhere_it_opens_and_proves_what_is_whole() {
    let scene = ball_on_cube();
    let rig = session(&scene, 700);
    let whole = recording(&scene, &rig.records);
    for i in 0..120 {
        let cut = ((0.5 + 0.5 * noise(i)) * whole.len() as f32) as usize;
        let expected = RecordReader::new(&mut whole[..cut].to_vec())
            .filter(|record| matches!(record, Ok(Record::Tick(tick)) if tick.flags & flags::NO_POSE == 0))
            .count();
        let verdict = verdict(&whole[..cut]);
        assert_eq!((verdict.counts.verified, verdict.counts.different), (expected as u64, 0), "cut at {cut}");
        assert!(verdict.damaged <= 1, "cut at {cut}");
    }
}

#[test]
fn flipped_anywhere_it_lies_about_nothing() {
    let scene = ball_on_cube();
    let rig = session(&scene, 700);
    let whole = recording(&scene, &rig.records);
    let begins = recording(&scene, &[]).len();
    for i in 0..120 {
        let at = ((0.5 + 0.5 * noise(1000 + i)) * whole.len() as f32) as usize;
        let mut bad = whole.clone();
        bad[at] ^= 1 << (i % 8);
        let verdict = verdict(&bad);
        assert_eq!((verdict.first, verdict.damaged > 0), (None, true), "byte {at}");
        if at > begins + 400 {
            let sure = RecordReader::new(&mut whole[..at].to_vec())
                .filter(|record| matches!(record, Ok(Record::Tick(tick)) if tick.flags & flags::NO_POSE == 0))
                .count();
            assert_eq!(verdict.counts.verified, sure as u64, "byte {at}");
        }
    }
}
