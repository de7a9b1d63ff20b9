//! The thread that writes files: the recording, and the black box with any fault.
//!
//! Both are rows of [`Record`] frames. The recording is written out every few milliseconds, so that a host that is killed leaves a
//! file that reads up to then. A disk that fails ends the writing, not the session: what was not written is counted.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use haptor_wire::frame::encode_stream;
use haptor_wire::recording::FRAME_MAX;
use haptor_wire::{Record, RecordHeader, Summary};
use rtrb::Consumer;

use crate::error::HostError;
use crate::rt::blackbox::{BlackBoxReader, Dump};

/// Time between two looks at the queues, and so the most that a kill can cost.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Black boxes written in a session: a device that faults for hours must not fill the disk. Further ones are counted.
const DUMPS_MAX: u32 = 16;

/// What became of the files.
#[derive(Debug, Default)]
pub struct Written {
    /// Records that could not be written.
    pub unwritten: u64,
    /// Black boxes written.
    pub dumps: u32,
    /// Faults whose black box was not written: no name given, too many, or the disk refused.
    pub dumps_left_out: u32,
    /// The first thing that went wrong.
    pub error: Option<HostError>,
}

/// The files of a session.
#[derive(Debug)]
pub struct Recorder {
    header: RecordHeader,
    recording: Option<(PathBuf, BufWriter<File>)>,
    black_box: Option<PathBuf>,
    written: Written,
}

impl Recorder {
    /// Creates the recording and writes its header. The black box is created with the first fault.
    ///
    /// # Errors
    /// [`HostError::File`] when the recording cannot be created.
    pub fn create(header: RecordHeader, recording: Option<PathBuf>, black_box: Option<PathBuf>) -> Result<Self, HostError> {
        let recording = match recording {
            None => None,
            Some(path) => match start_file(&path, &header) {
                Ok(file) => Some((path, file)),
                Err(reason) => return Err(HostError::File { doing: "create the recording", path, reason }),
            },
        };
        Ok(Self { header, recording, black_box, written: Written::default() })
    }

    /// Writes what comes until the summary, or until nobody can send one any more.
    #[must_use]
    pub fn run(mut self, mut records: Consumer<Record>, mut dumps: BlackBoxReader, end: &Receiver<Summary>) -> Written {
        loop {
            let ending = end.recv_timeout(LOOK_EVERY);
            self.drain(&mut records, &mut dumps);
            match ending {
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
                Ok(summary) => {
                    self.write(&Record::End(summary));
                    break;
                }
            }
        }
        self.flush();
        self.written
    }

    fn drain(&mut self, records: &mut Consumer<Record>, dumps: &mut BlackBoxReader) {
        while let Ok(record) = records.pop() {
            self.write(&record);
        }
        self.flush();
        while let Some(dump) = dumps.take() {
            self.write_dump(&dump);
            dumps.give_back(dump.ring);
        }
    }

    fn write(&mut self, record: &Record) {
        let Some((_, file)) = &mut self.recording else { return };
        if self.written.error.is_some() {
            self.written.unwritten += 1;
        } else if let Err(reason) = write_record(file, record) {
            self.written.unwritten += 1;
            self.failed(reason);
        }
    }

    fn flush(&mut self) {
        if let Some((_, file)) = &mut self.recording
            && let Err(reason) = file.flush()
        {
            self.failed(reason);
        }
    }

    fn failed(&mut self, reason: io::Error) {
        if let (None, Some((path, _))) = (&self.written.error, &self.recording) {
            self.written.error = Some(HostError::File { doing: "write the recording", path: path.clone(), reason });
        }
    }

    fn write_dump(&mut self, dump: &Dump) {
        let Some(path) = self.black_box.as_ref().filter(|_| self.written.dumps < DUMPS_MAX) else {
            self.written.dumps_left_out += 1;
            return;
        };
        let path = numbered(path, self.written.dumps);
        match write_black_box(&path, &self.header, dump) {
            Ok(()) => self.written.dumps += 1,
            Err(reason) => {
                self.written.dumps_left_out += 1;
                self.written.error.get_or_insert(HostError::File { doing: "write the black box", path, reason });
            }
        }
    }
}

/// `FILE`, then `FILE.2`, `FILE.3` for later faults.
fn numbered(path: &Path, before: u32) -> PathBuf {
    if before == 0 {
        return path.to_owned();
    }
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}", before + 1));
    name.into()
}

fn start_file(path: &Path, header: &RecordHeader) -> io::Result<BufWriter<File>> {
    let mut file = BufWriter::new(File::create(path)?);
    write_record(&mut file, &Record::Header(*header))?;
    file.flush()?;
    Ok(file)
}

fn write_black_box(path: &Path, header: &RecordHeader, dump: &Dump) -> io::Result<()> {
    let mut file = start_file(path, header)?;
    for tick in dump.ring.iter() {
        write_record(&mut file, &Record::Tick(*tick))?;
    }
    write_record(&mut file, &Record::Fault(dump.fault))?;
    file.flush()
}

fn write_record(file: &mut impl Write, record: &Record) -> io::Result<()> {
    let mut frame = [0; FRAME_MAX];
    // the buffer has the longest record's bound
    let length = encode_stream(record, &mut frame).map_err(io::Error::other)?;
    file.write_all(&frame[..length])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rt::blackbox::black_box;
    use haptor_wire::recording::RecordReader;
    use haptor_wire::{FaultRecord, HostFault, TickRecord};
    use std::sync::mpsc;

    const FAULT: FaultRecord = FaultRecord { cause: HostFault::Garbage, tick: 4, after_ticks: 20 };

    fn header() -> RecordHeader {
        RecordHeader { version: 1, schema: 2, rate_hz: 1000, scene_digest: 3, start_unix_s: 4 }
    }

    fn read(path: &Path) -> Vec<Record> {
        RecordReader::new(&std::fs::read(path).unwrap()).map(Result::unwrap).collect()
    }

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("haptor-host-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn a_session_with_two_faults_reads_back() {
        let folder = folder("recorder");
        let (recording, boxed) = (folder.join("s.rec"), folder.join("s.box"));
        let (mut ticks, reader) = rtrb::RingBuffer::new(16);
        let (mut writer, dumps) = black_box();
        let ticked = |tick| TickRecord { tick, ..TickRecord::default() };
        for tick in 0..5 {
            ticks.push(Record::Tick(ticked(tick))).unwrap();
            writer.record(&ticked(tick));
        }
        writer.hand_over(FAULT);
        writer.record(&ticked(5));
        writer.hand_over(FAULT);
        let (send, end) = mpsc::channel();
        send.send(Summary { ticks: 6, ..Summary::default() }).unwrap();
        let written = Recorder::create(header(), Some(recording.clone()), Some(boxed.clone())).unwrap().run(reader, dumps, &end);
        assert_eq!((written.dumps, written.dumps_left_out, written.unwritten), (2, 0, 0));

        let records = read(&recording);
        assert_eq!((records.len(), records[0]), (7, Record::Header(header())));
        assert!(matches!(records[6], Record::End(summary) if summary.ticks == 6));
        let (first, second) = (read(&boxed), read(&folder.join("s.box.2")));
        assert_eq!((first.len(), first[6]), (7, Record::Fault(FAULT)));
        assert_eq!(second[1], Record::Tick(ticked(5)));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_recording_that_cannot_be_created_is_named() {
        let error = Recorder::create(header(), Some("/nowhere/s.rec".into()), None).unwrap_err();
        assert!(error.to_string().starts_with("cannot create the recording /nowhere/s.rec: "), "{error}");
    }
}
