//! `haptor record`, `replay` and `export` as people and scripts use them: whole, altered, cut, foreign.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use haptor_wire::frame::encode_stream;
use haptor_wire::recording::FRAME_MAX;
use haptor_wire::{Record, RecordReader};
use serde_json::Value;

use crate::cli::{built, haptor};

const SCENE: &str = "tests/scenes/cube-twist.toml";
const TRAJECTORY: &str = "tests/scenes/cube-twist.csv";

/// A folder with an offline recording in it.
struct Desk {
    folder: tempfile::TempDir,
    file: PathBuf,
}

/// How a run of the tool ended.
struct Ended {
    code: Option<i32>,
    out: String,
    err: String,
}

fn run(args: &[&str]) -> Ended {
    let output = haptor().args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ended { code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
}

impl Desk {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("session.haptor");
        let ended = run(&["record", SCENE, "--trajectory", TRAJECTORY, "-o", file.to_str().unwrap()]);
        assert_eq!(ended.code, Some(0), "{}", ended.err);
        Self { folder, file }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A file of these bytes, verified.
    fn verify(&self, bytes: &[u8]) -> Ended {
        let file = self.path("other.haptor");
        fs::write(&file, bytes).unwrap();
        run(&["replay", file.to_str().unwrap(), "--verify"])
    }
}

fn verify(file: &Path) -> Value {
    let ended = run(&["replay", file.to_str().unwrap(), "--verify", "--json"]);
    let value: Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(value["passed"] == true, ended.code == Some(0), "{}", ended.err);
    value
}

/// The file with every record changed as `change` says.
fn rewritten(file: &Path, mut change: impl FnMut(&mut Record<'_>)) -> Vec<u8> {
    let (mut bytes, mut out) = (fs::read(file).unwrap(), Vec::new());
    for record in RecordReader::new(&mut bytes) {
        let (mut record, mut frame) = (record.unwrap(), [0; FRAME_MAX]);
        change(&mut record);
        let length = encode_stream(&record, &mut frame).unwrap();
        out.extend_from_slice(&frame[..length]);
    }
    out
}

#[test]
fn a_trajectory_is_recorded_to_the_same_bytes_and_verified_without_any_other_file() {
    let (desk, again) = (Desk::new(), Desk::new());
    assert_eq!(fs::read(&desk.file).unwrap(), fs::read(&again.file).unwrap());
    let value = verify(&desk.file);
    assert_eq!((&value["ticks"], &value["verified"], &value["damaged_places"]), (&701.into(), &701.into(), &0.into()));

    let shown = run(&["replay", desk.file.to_str().unwrap()]);
    for part in ["box of 3000000 Pa", "2.804 s, 701 ticks at 250 Hz", "tier bristle", "damage        none"] {
        assert!(shown.out.contains(part), "{part} missing in\n{}", shown.out);
    }
    let moment = run(&["replay", desk.file.to_str().unwrap(), "--at", "1.5", "--json"]);
    let moment: Value = serde_json::from_str(&moment.out).unwrap();
    assert_eq!((&moment["tick"], &moment["computed"]), (&375.into(), &"as recorded, to the bit".into()));
    assert!(moment["regions"][0]["radius"].as_f64().unwrap() > moment["regions"][0]["stick_radius"].as_f64().unwrap());
}

#[test]
fn what_differs_ends_with_1_tick_field_and_both_values() {
    let desk = Desk::new();
    let altered = rewritten(&desk.file, |record| {
        if let Record::Tick(tick) = record
            && tick.tick == 400
        {
            tick.contact_torque[2] = f32::from_bits(tick.contact_torque[2].to_bits() ^ 1);
        }
    });
    let ended = desk.verify(&altered);
    assert_eq!(ended.code, Some(1));
    for part in ["tick 400, contact_torque.z [N m]: recorded -", "(0x", "1 of 701 ticks differ"] {
        assert!(ended.err.contains(part), "{part} missing in {}", ended.err);
    }
}

#[test]
fn a_cut_file_verifies_as_far_as_it_goes_and_says_so() {
    let desk = Desk::new();
    let whole = fs::read(&desk.file).unwrap();
    let ended = desk.verify(&whole[..whole.len() / 2]);
    assert_eq!(ended.code, Some(0), "{}", ended.err);
    assert!(ended.out.contains("the recording ends within a frame"), "{}", ended.out);
    // within the scene: nothing can be computed
    let ended = desk.verify(&whole[..6000]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.err.contains("nothing in it can be verified"), "{}", ended.err);
}

#[test]
fn what_is_no_recording_of_this_version_ends_with_2() {
    let desk = Desk::new();
    let other = rewritten(&desk.file, |record| {
        if let Record::Header(header) = record {
            (header.version, header.schema) = (9, 0xDEAD_BEEF);
        }
    });
    let table: [(&[u8], &str); 3] =
        [(&other, "version 9 (table deadbeef)"), (b"solid cube", "no recording"), (b"", "no recording")];
    for (bytes, part) in table {
        let ended = desk.verify(bytes);
        assert_eq!(ended.code, Some(2), "{}", ended.err);
        assert!(ended.err.contains(part), "{part} missing in {}", ended.err);
    }
}

#[test]
fn csv_holds_what_eval_computes_and_the_poses() {
    let desk = Desk::new();
    let csv = run(&["export", desk.file.to_str().unwrap(), "--to", "csv"]).out;
    let eval = run(&["eval", SCENE, TRAJECTORY]).out;
    assert_eq!(csv.lines().count(), eval.lines().count());
    assert!(csv.starts_with(eval.lines().next().unwrap()), "{csv}");
    for (row, expected) in csv.lines().zip(eval.lines()).skip(1) {
        let fields = |row: &str, count: usize| row.split(',').skip(1).take(count).map(str::to_owned).collect::<Vec<_>>();
        // wrench, regions, depth, radius, stick, tier; the flags here know the guard of a device
        assert_eq!(fields(row, 11), fields(expected, 11));
        assert_eq!(row.split(',').count(), 30, "{row}");
    }
    assert!(csv.lines().nth(1).unwrap().ends_with("dynamic\""), "the first row says to what it was tuned");
}

#[test]
fn mcap_is_read_back_by_the_library_of_its_makers() {
    let desk = Desk::new();
    let out = desk.path("session.mcap");
    let ended = run(&["export", desk.file.to_str().unwrap(), "--to", "mcap", "-o", out.to_str().unwrap()]);
    assert_eq!(ended.code, Some(0), "{}", ended.err);
    let bytes = fs::read(out).unwrap();
    let (mut counts, mut last) = (BTreeMap::new(), 0);
    let mut tick = Value::Null;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.clone().unwrap();
        let _: Value = serde_json::from_slice(&schema.data).unwrap();
        let value: Value = serde_json::from_slice(&message.data).unwrap();
        assert!(message.log_time >= last, "in order of time");
        last = message.log_time;
        *counts.entry((message.channel.topic.clone(), schema.name.clone())).or_insert(0) += 1;
        if message.channel.topic == "/tick" && value["tick"] == 400 {
            tick = value;
        }
    }
    let counts: Vec<_> = counts.iter().map(|((topic, name), count)| (topic.as_str(), name.as_str(), *count)).collect();
    let expected = [
        ("/handle", "foxglove.PoseInFrame", 701),
        ("/log", "foxglove.Log", 1),
        ("/tf", "foxglove.FrameTransform", 1),
        ("/tick", "haptor.Tick", 701),
    ];
    assert_eq!(counts, expected);
    assert!(tick["contact_force"]["z"].as_f64().unwrap() > 20.0, "{tick}");
    assert!(mcap::Summary::read(&bytes).unwrap().is_some(), "it has an index");
}

#[test]
fn a_session_with_a_device_is_recorded_and_verified() {
    built("haptor-host");
    built("haptor-firmware-sim");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.haptor");
    let name = file.to_str().unwrap();
    // a busy machine may miss deadlines: what was recorded must come out again all the same
    run(&["record", SCENE, "--device", "sim", "--rt", "ignore", "--seconds", "2", "-o", name]);
    let value = verify(&file);
    assert_eq!((&value["different"], &value["unverifiable"]), (&0.into(), &0.into()), "{value}");
    assert!(value["verified"].as_u64().unwrap() > 500, "{value}");
    let shown = run(&["replay", name]).out;
    assert!(shown.contains("premium15") && shown.contains("end           in order"), "{shown}");
}
