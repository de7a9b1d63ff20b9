//! Computes recordings again on a Cortex-M7: reads the poses of the file that it was built with, one recording after the other, answers each with the engine that the host runs,
//! and writes a file of its own to the emulator's standard output over semihosting.
//!
//! No heap, no operating system. What it says in words goes to standard error. The emulator ends with success only if every tick came out as recorded, to the bit.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

use cortex_m_rt::entry;
use cortex_m_semihosting::hio::{self, HostStream};
use cortex_m_semihosting::{debug, heprintln};
use haptor_engine::bodies::NoMeshes;
use haptor_engine::replay::{Difference, Follower, Step, answered, compare};
use haptor_engine::{Bodies, Engine, Setup};
use haptor_wire::recording::FRAME_MAX;
use haptor_wire::scene_file::{FILE_MAX, decode_file};
use haptor_wire::{BakedScene, Record, RecordHeader, RecordReader, encode_stream};
use heapless::Vec;

/// Bytes of the recording.
const LENGTH: usize = include_bytes!(env!("HAPTOR_RECORDING")).len();

/// Why the session failed.
enum Failure {
    /// In words.
    Words(&'static str),
    /// A tick came out otherwise.
    Differs(Difference),
}

impl From<&'static str> for Failure {
    fn from(words: &'static str) -> Self {
        Self::Words(words)
    }
}

#[entry]
fn main() -> ! {
    let status = match session() {
        Ok(ticks) => {
            heprintln!("{} ticks computed again, equal to the bit", ticks);
            debug::EXIT_SUCCESS
        }
        Err(Failure::Words(words)) => {
            heprintln!("{}", words);
            debug::EXIT_FAILURE
        }
        Err(Failure::Differs(difference)) => {
            heprintln!("{}", difference);
            debug::EXIT_FAILURE
        }
    };
    debug::exit(status);
    loop {
        cortex_m::asm::wfi();
    }
}

/// The whole file, one recording after the other; yields its ticks.
fn session() -> Result<u32, Failure> {
    // reading a recording decodes it onto itself, so it is copied into memory
    let recording: &'static mut [u8; LENGTH] =
        cortex_m::singleton!(: [u8; LENGTH] = *include_bytes!(env!("HAPTOR_RECORDING"))).ok_or("begun twice")?;
    let mut out = hio::hstdout().map_err(|()| "no standard output")?;
    let mut reader = RecordReader::new(recording);
    let (mut ticks, mut next) = (0, None);
    while let Some((header, scene)) = beginning(&mut reader, next, &mut out)? {
        let computed;
        (computed, next) = ticks_of(&mut reader, &header, &scene, &mut out)?;
        ticks += computed;
    }
    if ticks == 0 { Err("no ticks in the recording".into()) } else { Ok(ticks) }
}

/// Header and scene; both are passed on. The header may have been read already; `None` at the end of the file.
fn beginning(
    reader: &mut RecordReader<'_>,
    mut header: Option<RecordHeader>,
    out: &mut HostStream,
) -> Result<Option<(RecordHeader, BakedScene)>, Failure> {
    let mut file = Vec::<u8, FILE_MAX>::new();
    for record in reader {
        let record = record.map_err(|_| "the recording is damaged")?;
        write(&record, out)?;
        match (record, header) {
            (Record::Header(first), _) => header = Some(first),
            (Record::Scene(chunk), Some(header)) => {
                file.extend_from_slice(chunk.bytes).map_err(|_| "the scene carries more than shapes")?;
                if file.len() == header.scene_bytes as usize {
                    return Ok(Some((header, decode_file(&file).map_err(|_| "the scene cannot be read")?)));
                }
            }
            _ => {}
        }
    }
    if header.is_some() { Err("the recording has no scene".into()) } else { Ok(None) }
}

/// Computes the ticks of a scene again, up to the header of the next one, which is passed on; yields how many, and that header.
fn ticks_of(
    reader: &mut RecordReader<'_>,
    header: &RecordHeader,
    scene: &BakedScene,
    out: &mut HostStream,
) -> Result<(u32, Option<RecordHeader>), Failure> {
    let setup = Setup::new(scene).map_err(|_| "the scene is refused")?;
    let bodies = Bodies::new(scene, &NoMeshes, None).map_err(|_| "the scene needs more than shapes")?;
    let mut engine = Engine::new(&setup, &bodies).map_err(|_| "the scene is refused")?;
    let mut follower = Follower::new(header);
    let mut ticks = 0;
    for record in reader {
        let record = record.map_err(|_| "the recording is damaged")?;
        let step = follower.take(&mut engine, &record);
        let (Record::Tick(asked), Step::Felt(felt, sure)) = (record, step) else {
            write(&record, out)?;
            if let Record::Header(next) = record {
                return Ok((ticks, Some(next)));
            }
            continue;
        };
        write(&Record::Tick(answered(&asked, &felt)), out)?;
        sure.map_err(|_| "the recording does not say what the core remembered")?;
        compare(&asked, &felt).map_or(Ok(()), |difference| Err(Failure::Differs(difference)))?;
        ticks += 1;
    }
    Ok((ticks, None))
}

fn write(record: &Record<'_>, out: &mut HostStream) -> Result<(), Failure> {
    let mut frame = [0; FRAME_MAX];
    let length = encode_stream(record, &mut frame).map_err(|_| "a record is longer than any may be")?;
    let bytes = frame.get(..length).unwrap_or(&[]);
    out.write_all(bytes).map_err(|()| "standard output does not take it".into())
}

/// Ends the emulator: a panic is a failed session.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    heprintln!("panicked");
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}
