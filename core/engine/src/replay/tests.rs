//! Recordings made by hand, computed again whole, cut, flipped and altered.

use haptor_wire::frame::encode_stream;
use haptor_wire::recording::{Chunk, FRAME_MAX};
use haptor_wire::{
    Event, PROTOCOL_VERSION, Place, Record, RecordHeader, RecordReader, SessionHello, TOOL_SCHEMA_HASH, TickRecord, Tuning, What,
    flags, scene_file,
};

use super::{Follower, Step, Unsure, Verdict, answered, verify};
use crate::Scene;
use crate::tests::baked;

/// Frames in a row, and an engine that answers ticks.
struct Author {
    file: Vec<u8>,
    engine: crate::OwnedEngine,
    follower: Follower,
    ends: Vec<usize>,
}

impl Author {
    fn new() -> Self {
        let mut scene = vec![0; scene_file::FILE_MAX];
        let length = scene_file::encode_file(&baked(), &mut scene).unwrap();
        scene.truncate(length);
        let header = RecordHeader {
            version: PROTOCOL_VERSION,
            schema: TOOL_SCHEMA_HASH,
            rate_hz: 1000,
            scene_digest: scene_file::digest(&scene),
            start_unix_s: 0,
            schema_bytes: 0,
            scene_bytes: length as u32,
        };
        let engine = Scene::read(&scene).unwrap().engine().unwrap();
        let mut author = Self { file: Vec::new(), engine, follower: Follower::new(&header), ends: Vec::new() };
        author.write(&Record::Header(header));
        Chunk::of(&scene).for_each(|chunk| author.write(&Record::Scene(chunk)));
        author
    }

    fn write(&mut self, record: &Record<'_>) {
        let mut frame = [0; FRAME_MAX];
        let length = encode_stream(record, &mut frame).unwrap();
        self.file.extend_from_slice(&frame[..length]);
        self.ends.push(self.file.len());
    }

    fn say(&mut self, record: Record<'_>) {
        assert_eq!(self.engine.with(|engine| self.follower.take(engine, &record)), Step::Noted);
        self.write(&record);
    }

    /// What a host says before a rest, and the rest.
    fn rest(&mut self, tuning: Tuning, place: Place) {
        self.say(Record::Device(SessionHello {
            version: 1,
            schema: 2,
            period_us: 1000,
            device_name: [0; 12],
            device_serial: [0; 12],
            max_force_un: 3_000_000,
            max_torque_unm: 100_000,
            rt: haptor_wire::RtReport::default(),
            work: None,
        }));
        self.say(Record::Tuning(tuning));
        self.say(Record::Place(place));
        self.say(Record::Rest);
    }

    /// Presses 0.5 mm and drags; `with` spoils what is written.
    fn ticks(&mut self, ticks: std::ops::Range<u64>, with: impl Fn(&mut TickRecord)) {
        for tick in ticks {
            let along = 1.0e-5 * (tick % 100) as f32;
            let asked = TickRecord {
                tick,
                t_us: 1000 * tick,
                position: [along, 0.0, 0.0199 - 0.4 * along],
                rotation: [1.0, 0.0, 0.0, 0.0],
                ..TickRecord::default()
            };
            let step = self.engine.with(|engine| self.follower.take(engine, &Record::Tick(asked)));
            let Step::Felt(felt, _) = step else { panic!("{step:?}") };
            let mut tick = answered(&asked, &felt);
            with(&mut tick);
            self.write(&Record::Tick(tick));
        }
    }

    fn verdict(&self) -> Verdict {
        verify(&mut self.file.clone(), |_| ()).unwrap()
    }
}

/// A session with everything in it.
fn session() -> Author {
    let mut author = Author::new();
    let place = baked().place;
    author.rest(Tuning::of(&baked()), place);
    author.ticks(0..40, |_| ());
    author.say(Record::Event(Event { tick: 40, what: What::Mark }));
    author.say(Record::Tuning(Tuning { friction_static: 0.3, friction_dynamic: 0.2, ..Tuning::of(&baked()) }));
    author.ticks(40..60, |_| ());
    // no pose came in tick 60: the next one covers two
    author.write(&Record::Tick(TickRecord { tick: 60, flags: flags::NO_POSE, ..TickRecord::default() }));
    author.ticks(61..80, |tick| tick.flags |= flags::LATE);
    author.rest(Tuning::of(&baked()), Place { p_wd: [0.0, 0.0, -1.0e-4], ..place });
    author.ticks(80..100, |_| ());
    author
}

#[test]
fn a_session_comes_out_again_to_the_bit() {
    let verdict = session().verdict();
    let counts = verdict.counts;
    assert_eq!((counts.ticks, counts.verified, counts.idle, counts.unverifiable), (100, 99, 1, 0), "{verdict:?}");
    assert_eq!((verdict.first, verdict.no_scene, verdict.damaged), (None, None, 0));
    assert_eq!(verdict.digest, session().verdict().digest);
}

#[test]
fn what_differs_is_named_by_tick_and_field() {
    type Spoil = fn(&mut TickRecord);
    let table: [(Spoil, &str); 6] = [
        (|t| t.contact_force[2] = f32::from_bits(t.contact_force[2].to_bits() ^ 1), "tick 10, contact_force.z [N]: recorded "),
        (|t| t.contact_torque[0] += 1.0, "contact_torque.x"),
        (|t| t.regions += 1, "regions: recorded 2, computed 1"),
        (|t| t.tier = haptor_wire::Tier::Paper, "tier: recorded paper, computed bristle"),
        (|t| t.flags |= 2, "flags of the core"),
        (|t| t.force[0] += 1.0, "force.x"),
    ];
    for (spoil, named) in table {
        let mut author = Author::new();
        author.rest(Tuning::of(&baked()), baked().place);
        author.ticks(0..20, |tick| {
            if tick.tick == 10 {
                spoil(tick);
            }
        });
        let verdict = author.verdict();
        let text = verdict.first.map(|first| first.to_string()).unwrap_or_default();
        assert!(text.contains(named), "{text} lacks {named}");
        assert_eq!((verdict.counts.different, verdict.counts.verified), (1, 19));
    }
    // what the output was closed for was not sent
    let mut author = Author::new();
    author.rest(Tuning::of(&baked()), baked().place);
    author.ticks(0..20, |tick| (tick.force, tick.flags) = ([0.0; 3], tick.flags | flags::CLOSED));
    assert_eq!(author.verdict().counts.verified, 20);
}

#[test]
fn a_session_cut_anywhere_verifies_up_to_its_last_whole_tick() {
    let author = session();
    let mut whole = 0;
    for cut in 0..=author.file.len() {
        if author.ends.contains(&cut) {
            let frame = author.ends.iter().position(|&end| end == cut).unwrap();
            let from = frame.checked_sub(1).map_or(0, |before| author.ends[before]);
            let mut last = author.file[from..cut].to_vec();
            whole += u64::from(matches!(RecordReader::new(&mut last).next(), Some(Ok(Record::Tick(t))) if t.tick != 60));
        }
        // every byte of the frames around the scene's end and of some ticks; every eleventh elsewhere
        if cut % 11 == 0 || cut < 60 {
            let verdict = verify(&mut author.file[..cut].to_vec(), |_| ()).unwrap();
            assert_eq!((verdict.counts.verified, verdict.counts.different), (whole, 0), "cut at {cut}");
        }
    }
    assert_eq!(whole, 99);
}

#[test]
fn a_flipped_byte_costs_what_follows_it_up_to_the_next_rest_and_lies_about_nothing() {
    let author = session();
    for at in (0..author.file.len()).step_by(37) {
        let mut bad = author.file.clone();
        bad[at] ^= 0x40;
        let verdict = verify(&mut bad, |_| ()).unwrap();
        assert_eq!((verdict.counts.different, verdict.first), (0, None), "byte {at}");
        assert!(verdict.damaged > 0, "byte {at}");
        let frame = author.ends.iter().filter(|&&end| end <= at).count();
        // the last twenty ticks follow a rest of their own; without header or scene nothing can be computed
        let second_rest = author.ends.len() - 24;
        assert!(verdict.counts.verified >= 20 || frame < 2 || frame >= second_rest, "byte {at}, frame {frame}: {verdict:?}");
    }
}

#[test]
fn records_without_a_beginning_prove_nothing_and_say_why() {
    let mut author = Author::new();
    author.ticks(0..5, |_| ());
    let verdict = author.verdict();
    assert_eq!((verdict.counts.verified, verdict.counts.unverifiable, verdict.unsure), (0, 5, Some(Unsure::NoRest)));

    author.say(Record::Lost { count: 7 });
    author.ticks(5..10, |_| ());
    author.say(Record::Rest);
    author.ticks(10..15, |_| ());
    assert_eq!(author.verdict().counts.unverifiable, 15, "nobody has said to what the core was tuned");
    author.rest(Tuning::of(&baked()), baked().place);
    author.ticks(15..20, |_| ());
    assert_eq!(author.verdict().counts.verified, 5);
}

#[test]
fn files_may_be_joined_and_other_versions_are_refused() {
    let one = session().file;
    let verdict = verify(&mut [one.clone(), one].concat(), |_| ()).unwrap();
    assert_eq!((verdict.counts.verified, verdict.damaged), (198, 0));

    let mut author = Author::new();
    author.write(&Record::Header(RecordHeader {
        version: 9,
        schema: 1,
        rate_hz: 1,
        scene_digest: 0,
        start_unix_s: 0,
        schema_bytes: 0,
        scene_bytes: 0,
    }));
    assert_eq!(verify(&mut author.file, |_| ()).unwrap_err().their_version, 9);
}

#[test]
fn an_engine_goes_on_from_what_another_kept() {
    let mut author = Author::new();
    author.rest(Tuning::of(&baked()), baked().place);
    author.ticks(0..30, |_| ());
    let (kept, follower) = (author.engine.get().keep(), author.follower);
    let from = author.file.len();
    author.ticks(30..60, |_| ());
    let first = author.file[from..].to_vec();
    author.engine.with(|engine| engine.go_on_from(&kept));
    author.follower = follower;
    let from = author.file.len();
    author.ticks(30..60, |_| ());
    assert_eq!(author.file[from..], first);
}
