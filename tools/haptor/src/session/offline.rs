//! A recording without a device: the poses of a trajectory, answered by the engine that the host would run. The same bytes every time.

use haptor_contact::Vec3;
use haptor_engine::replay::{Follower, Step, answered};
use haptor_engine::{Engine, Scene};
use haptor_wire::frame::encode_stream;
use haptor_wire::recording::{Chunk, FRAME_MAX};
use haptor_wire::schema::TOOL_TABLE;
use haptor_wire::{PROTOCOL_VERSION, Place, Record, RecordHeader, Summary, TOOL_SCHEMA_HASH, TickRecord, Tuning, scene_file};

use crate::trajectory::Row;

/// How far a row may lie from its tick: a hundredth of one.
const OFF_TICK: f64 = 0.01;

/// A recording that grows.
struct Sheet {
    frames: Vec<u8>,
}

impl Sheet {
    fn add(&mut self, record: &Record<'_>) -> Result<(), String> {
        let mut frame = [0; FRAME_MAX];
        let length = encode_stream(record, &mut frame).map_err(|error| error.to_string())?;
        self.frames.extend_from_slice(&frame[..length]);
        Ok(())
    }
}

/// Records a trajectory on the file of a baked scene.
///
/// # Errors
/// In words, what of scene or trajectory cannot be recorded.
pub fn record(scene: &[u8], rows: &[Row], rate_hz: u32) -> Result<Vec<u8>, String> {
    let read = Scene::read(scene).map_err(|error| error.to_string())?;
    let begin = begin(&Tuning::of(read.setup().baked()));
    let ticks = rows.iter().map(|row| tick(row, rows, rate_hz).map(Record::Tick));
    answer(scene, rate_hz, begin.into_iter().map(Ok).chain(ticks), |_, _| ())
}

/// What a session whose poses are in the world begins with.
pub fn begin(tuning: &Tuning) -> [Record<'static>; 3] {
    let place = Place { p_wd: [0.0; 3], q_wd: [1.0, 0.0, 0.0, 0.0] };
    [Record::Tuning(*tuning), Record::Place(place), Record::Rest]
}

/// Records what is asked for on the file of a baked scene: ticks with the engine's answers, everything else as it is. `heard` is told each answer, and the
/// engine it came from.
///
/// # Errors
/// In words, what of scene or records cannot be recorded.
pub fn answer(
    scene: &[u8],
    rate_hz: u32,
    asked: impl IntoIterator<Item = Result<Record<'static>, String>>,
    mut heard: impl FnMut(&TickRecord, &Engine<'_>),
) -> Result<Vec<u8>, String> {
    let header = header(scene, rate_hz)?;
    let mut engine = Scene::read(scene).and_then(|read| read.engine()).map_err(|error| error.to_string())?;
    let mut follower = Follower::new(&header);
    let mut sheet = Sheet { frames: Vec::new() };
    sheet.add(&Record::Header(header))?;
    Chunk::of(TOOL_TABLE.as_bytes()).try_for_each(|chunk| sheet.add(&Record::Schema(chunk)))?;
    Chunk::of(scene).try_for_each(|chunk| sheet.add(&Record::Scene(chunk)))?;
    let mut summary = Summary::default();
    for record in asked {
        let record = record?;
        let step = engine.with(|engine| follower.take(engine, &record));
        match (&record, step) {
            (Record::Tick(asked), Step::Felt(felt, _)) => {
                let ticked = answered(asked, &felt);
                sheet.add(&Record::Tick(ticked))?;
                sum_up(&mut summary, &ticked);
                heard(&ticked, engine.get());
            }
            (Record::Tick(asked), _) => return Err(format!("the pose of tick {} is none", asked.tick)),
            _ => sheet.add(&record)?,
        }
    }
    sheet.add(&Record::End(summary))?;
    Ok(sheet.frames)
}

fn header(scene: &[u8], rate_hz: u32) -> Result<RecordHeader, String> {
    Ok(RecordHeader {
        version: PROTOCOL_VERSION,
        schema: TOOL_SCHEMA_HASH,
        rate_hz,
        scene_digest: scene_file::digest(scene),
        // no clock: the same bytes every time
        start_unix_s: 0,
        schema_bytes: TOOL_TABLE.len() as u32,
        scene_bytes: u32::try_from(scene.len()).map_err(|_| "the baked scene is longer than 4 GB")?,
    })
}

/// Every tick is in time: nobody waits for it.
fn sum_up(summary: &mut Summary, tick: &TickRecord) {
    let magnitude = |v: [f32; 3]| Vec3::from_array(v).length();
    (summary.ticks, summary.in_time) = (summary.ticks + 1, summary.in_time + 1);
    summary.peak_force = summary.peak_force.max(magnitude(tick.contact_force));
    summary.peak_torque = summary.peak_torque.max(magnitude(tick.contact_torque));
}

/// What goes into a tick.
fn tick(row: &Row, rows: &[Row], rate_hz: u32) -> Result<TickRecord, String> {
    let since = row.t - rows.first().map_or(0.0, |first| first.t);
    let at = since * f64::from(rate_hz);
    if (at - at.round()).abs() > OFF_TICK {
        return Err(format!(
            "t = {} lies between two ticks at {rate_hz} Hz; give the trajectory's own rate with --rate, or space its rows evenly",
            row.written_t
        ));
    }
    let (Vec3 { x, y, z }, q) = (row.position, row.rotation);
    Ok(TickRecord {
        tick: at.round() as u64,
        t_us: (since * 1.0e6).round() as u64,
        position: [x, y, z],
        rotation: [q.w, q.x, q.y, q.z],
        ..TickRecord::default()
    })
}
