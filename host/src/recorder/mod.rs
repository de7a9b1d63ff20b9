//! The thread that writes files: the recording, and the black box with any fault; and passes the same frames to whoever reads along.
//!
//! All are rows of [`Record`] frames ([`haptor_wire::recording`]). The recording is written out every few milliseconds, so that a host that is killed leaves a
//! file that reads up to then. A disk that fails ends the writing, not the session: what was not written is counted.
//!
//! | file | what it is |
//! |---|---|
//! | [`origin`] | what a recording begins with |
//! | [`orders`] | what other threads may ask |
//! | [`tap`] | readers of the recording while it is made |

pub mod orders;
pub mod origin;
pub mod tap;

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use haptor_wire::frame::FrameError;
use haptor_wire::{Event, Record, RecordHeader, Summary, What};
use rtrb::Consumer;

use self::orders::{Order, Orders, orders};
use self::origin::{Frames, Origin, Standing, append};
use self::tap::TapEnd;
use crate::error::HostError;
use crate::rt::blackbox::{BlackBoxReader, Dump};
use crate::viewer::figures::SharedFigures;

/// Time between two looks at the queues, and so the most that a kill can cost.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Black boxes written in a session: a device that faults for hours must not fill the disk. Further ones are counted.
const DUMPS_MAX: u32 = 16;

/// Scenes known at once that a session may go to: the one it runs, the one it goes to, and one that was sent meanwhile.
const SCENES_MAX: usize = 3;

/// What became of the files.
#[derive(Debug, Default)]
pub struct Written {
    /// Records that could not be written.
    pub unwritten: u64,
    /// Black boxes written.
    pub dumps: u32,
    /// Faults whose black box was not written: no name given, too many, too soon one after another, or the disk refused.
    pub dumps_left_out: u32,
    /// The first thing that went wrong.
    pub error: Option<HostError>,
}

/// What the recorder reads: the real-time thread's queues.
#[derive(Debug)]
pub struct Sources {
    /// Device, settings, ticks, faults.
    pub records: Consumer<Record<'static>>,
    /// Black boxes.
    pub dumps: BlackBoxReader,
    /// Set to ask for a `Rest`.
    pub rest_wanted: Arc<AtomicBool>,
}

/// A recording that is being made.
#[derive(Debug)]
struct Recording {
    path: PathBuf,
    file: BufWriter<File>,
    /// The disk has refused: nothing more is written.
    failed: bool,
}

/// The files of a session.
#[derive(Debug)]
pub struct Recorder {
    origin: Origin,
    /// Scenes that the session may go to.
    scenes: Vec<Origin>,
    standing: Standing,
    recording: Option<Recording>,
    black_box: Option<PathBuf>,
    taps: Vec<TapEnd>,
    orders: Receiver<Order>,
    rest_wanted: Arc<AtomicBool>,
    /// Records told as lost.
    lost: u64,
    written: Written,
    figures: SharedFigures,
}

impl Recorder {
    /// Creates the recording and writes what it begins with. The black box is created with the first fault.
    ///
    /// # Errors
    /// [`HostError::File`] when the recording cannot be created.
    pub fn create(origin: Origin, recording: Option<PathBuf>, black_box: Option<PathBuf>) -> Result<(Self, Orders), HostError> {
        let (asked, orders) = orders();
        let mut recorder = Self {
            origin,
            scenes: Vec::new(),
            standing: Standing::default(),
            recording: None,
            black_box,
            taps: Vec::new(),
            orders,
            rest_wanted: Arc::default(),
            lost: 0,
            written: Written::default(),
            figures: SharedFigures::default(),
        };
        recording.map_or(Ok(()), |path| recorder.begin(path))?;
        Ok((recorder, asked))
    }

    /// Keeps these figures of the session, for others to read.
    #[must_use]
    pub fn with_figures(self, figures: SharedFigures) -> Self {
        Self { figures, ..self }
    }

    /// Writes what comes until the summary, or until nobody can send one any more.
    #[must_use]
    pub fn run(mut self, mut sources: Sources, end: &Receiver<Summary>) -> Written {
        self.rest_wanted = Arc::clone(&sources.rest_wanted);
        loop {
            let ending = end.recv_timeout(LOOK_EVERY);
            self.obey();
            self.drain(&mut sources);
            match ending {
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
                Ok(summary) => {
                    self.conclude(&summary);
                    break;
                }
            }
        }
        self.flush();
        self.written
    }

    fn obey(&mut self) {
        while let Ok(order) = self.orders.try_recv() {
            // whoever asked may not wait any more
            match order {
                Order::Begin(path, answer) => drop(answer.send(self.begin_while_running(path))),
                Order::End(answer) => drop(answer.send(self.end())),
                Order::Tap(tap) => self.open_tap(tap),
                Order::Scene(file) => self.know(Origin::new(self.origin.header.rate_hz, file)),
            }
        }
    }

    fn know(&mut self, scene: Origin) {
        self.scenes.retain(|known| known.header.scene_digest != scene.header.scene_digest);
        if self.scenes.len() == SCENES_MAX {
            self.scenes.remove(0);
        }
        self.scenes.push(scene);
    }

    fn drain(&mut self, sources: &mut Sources) {
        while let Ok(record) = sources.records.pop() {
            self.take(&record);
        }
        self.flush();
        while let Some(dump) = sources.dumps.take() {
            self.write_dump(&dump);
            sources.dumps.give_back(dump.ring);
        }
        self.written.dumps_left_out += sources.dumps.take_lost();
    }

    /// A record of the real-time thread.
    fn take(&mut self, record: &Record<'static>) {
        match *record {
            Record::Header(header) => return self.go_to(&header),
            Record::Lost { count } => {
                self.lost += count;
                self.rest_wanted.store(true, Ordering::Relaxed);
            }
            _ => {}
        }
        self.standing.note(record);
        self.figures.note(record);
        self.pass(record);
    }

    /// The session goes on with another scene.
    fn go_to(&mut self, header: &RecordHeader) {
        let digest = header.scene_digest;
        let known = self.scenes.iter().find(|known| known.header.scene_digest == digest).cloned();
        // a scene that nobody sent here is known by its digest only
        let next = known.unwrap_or_else(|| {
            let mut unknown = Origin::new(header.rate_hz, Arc::default());
            unknown.header.scene_digest = digest;
            unknown
        });
        let last = std::mem::replace(&mut self.origin, next);
        if last.header.scene_bytes > 0 {
            self.know(last);
        }
        self.standing = Standing { tick: self.standing.tick, ..Standing::default() };
        match self.origin.frames() {
            Ok(frames) => self.pass_frames(&frames.into(), 1),
            Err(error) => self.failed(io::Error::other(error)),
        }
    }

    /// Ends the session's files with its summary; what was lost at the very end is told first.
    fn conclude(&mut self, summary: &Summary) {
        let count = summary.recorder_dropped.saturating_sub(self.lost);
        if count > 0 {
            self.pass(&Record::Lost { count });
        }
        self.pass(&Record::End(*summary));
    }

    fn pass(&mut self, record: &Record<'_>) {
        if self.recording.is_none() && self.taps.is_empty() {
            return;
        }
        let mut frames = Vec::new();
        match append(&mut frames, record) {
            Ok(()) => self.pass_frames(&frames.into(), 1),
            Err(error) => self.failed(io::Error::other(error)),
        }
    }

    fn pass_frames(&mut self, frames: &Frames, records: u64) {
        self.taps.retain_mut(|tap| tap.pass(frames, records));
        let Some(recording) = &mut self.recording else { return };
        if recording.failed {
            self.written.unwritten += records;
        } else if let Err(reason) = recording.file.write_all(frames) {
            self.written.unwritten += records;
            self.failed(reason);
        }
    }

    /// Opens a file, with all that came before its first tick.
    fn begin(&mut self, path: PathBuf) -> Result<(), HostError> {
        if self.recording.is_some() {
            let reason = io::Error::other("a recording is being made; end it first");
            return Err(HostError::File { doing: "begin the recording", path, reason });
        }
        match self.opening().and_then(|frames| start_file(&path, &frames)) {
            Ok(file) => self.recording = Some(Recording { path, file, failed: false }),
            Err(reason) => return Err(HostError::File { doing: "create the recording", path, reason }),
        }
        Ok(())
    }

    fn begin_while_running(&mut self, path: PathBuf) -> Result<(), HostError> {
        self.begin(path)?;
        self.rest_wanted.store(true, Ordering::Relaxed);
        self.pass(&Record::Event(Event { tick: self.standing.tick, what: What::RecordingBegun }));
        Ok(())
    }

    fn end(&mut self) -> bool {
        if self.recording.is_none() {
            return false;
        }
        self.pass(&Record::Event(Event { tick: self.standing.tick, what: What::RecordingEnded }));
        self.flush();
        self.recording.take().is_some()
    }

    fn open_tap(&mut self, mut tap: TapEnd) {
        // without a tap that takes it, its reader sees a closed queue
        let Ok(frames) = self.opening() else { return };
        if tap.pass(&frames.into(), 1) {
            self.rest_wanted.store(true, Ordering::Relaxed);
            self.taps.push(tap);
        }
    }

    /// What a reader who begins now must know.
    fn opening(&self) -> io::Result<Vec<u8>> {
        let mut frames = self.origin.frames().map_err(io::Error::other)?;
        self.standing.append_to(&mut frames).map_err(io::Error::other)?;
        Ok(frames)
    }

    fn flush(&mut self) {
        if let Some(Recording { file, failed: false, .. }) = &mut self.recording
            && let Err(reason) = file.flush()
        {
            self.failed(reason);
        }
    }

    fn failed(&mut self, reason: io::Error) {
        let Some(Recording { path, failed, .. }) = &mut self.recording else { return };
        *failed = true;
        self.written.error.get_or_insert(HostError::File { doing: "write the recording", path: path.clone(), reason });
    }

    fn write_dump(&mut self, dump: &Dump) {
        let Some(path) = self.black_box.as_ref().filter(|_| self.written.dumps < DUMPS_MAX) else {
            self.written.dumps_left_out += 1;
            return;
        };
        let path = numbered(path, self.written.dumps);
        match self.black_box_frames(dump).map_err(io::Error::other).and_then(|frames| start_file(&path, &frames)) {
            Ok(_) => self.written.dumps += 1,
            Err(reason) => {
                self.written.dumps_left_out += 1;
                self.written.error.get_or_insert(HostError::File { doing: "write the black box", path, reason });
            }
        }
    }

    /// The last ticks and the fault, with the device that was there and the scene's digest.
    fn black_box_frames(&self, dump: &Dump) -> Result<Vec<u8>, FrameError> {
        let mut frames = self.origin.without_scene()?;
        self.standing.append_to(&mut frames)?;
        dump.ring.iter().try_for_each(|tick| append(&mut frames, &Record::Tick(*tick)))?;
        append(&mut frames, &Record::Fault(dump.fault))?;
        Ok(frames)
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

fn start_file(path: &Path, frames: &[u8]) -> io::Result<BufWriter<File>> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(frames)?;
    file.flush()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rt::blackbox::black_box;
    use haptor_wire::recording::RecordReader;
    use haptor_wire::{FaultRecord, HostFault, RtReport, SessionHello, TickRecord};
    use std::sync::mpsc;

    const FAULT: FaultRecord = FaultRecord { cause: HostFault::Garbage, tick: 4, after_ticks: 20 };

    const HELLO: SessionHello = SessionHello {
        version: 1,
        schema: 2,
        period_us: 1000,
        device_name: [0; 12],
        device_serial: [0; 12],
        max_force_un: 1,
        max_torque_unm: 1,
        rt: RtReport { fifo: false, locked: false, pinned: false, dma_latency: false },
        work: None,
    };

    fn origin() -> Origin {
        Origin::new(1000, vec![7; 3000].into())
    }

    fn read(path: &Path) -> Vec<String> {
        records(&mut std::fs::read(path).unwrap())
    }

    /// The records, each by its name and what tells it from others.
    fn records(file: &mut [u8]) -> Vec<String> {
        let name = |record: Record<'_>| match record {
            Record::Tick(tick) => format!("tick {}", tick.tick),
            Record::Scene(chunk) => format!("scene {}", chunk.at),
            Record::Lost { count } => format!("lost {count}"),
            Record::Event(event) => format!("{} {}", event.what.name(), event.tick),
            Record::End(summary) => format!("end {}", summary.ticks),
            other => format!("{other:?}").split('(').next().unwrap_or_default().to_lowercase(),
        };
        let all = RecordReader::new(file).map(|record| name(record.unwrap()));
        all.filter(|name| name != "schema").collect()
    }

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("haptor-host-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    /// A recorder at work on records that are pushed by hand.
    struct Desk {
        records: rtrb::Producer<Record<'static>>,
        box_writer: crate::rt::blackbox::BlackBox,
        rest_wanted: Arc<AtomicBool>,
        orders: Orders,
        end: mpsc::Sender<Summary>,
        thread: std::thread::JoinHandle<Written>,
    }

    impl Desk {
        fn new(recording: Option<PathBuf>, boxed: Option<PathBuf>) -> Self {
            let (records, reader) = rtrb::RingBuffer::new(64);
            let (box_writer, dumps) = black_box(1000);
            let rest_wanted = Arc::new(AtomicBool::new(false));
            let (end, ends) = mpsc::channel();
            let (recorder, orders) = Recorder::create(origin(), recording, boxed).unwrap();
            let sources = Sources { records: reader, dumps, rest_wanted: Arc::clone(&rest_wanted) };
            let thread = std::thread::spawn(move || recorder.run(sources, &ends));
            Self { records, box_writer, rest_wanted, orders, end, thread }
        }

        fn tick(&mut self, tick: u64) {
            let ticked = TickRecord { tick, ..TickRecord::default() };
            self.records.push(Record::Tick(ticked)).unwrap();
            self.box_writer.record(&ticked);
        }

        /// Waits until everything pushed has been taken.
        fn settle(&self) {
            while self.records.slots() < 64 {
                std::thread::sleep(Duration::from_millis(1));
            }
        }

        fn finish(self, summary: Summary) -> Written {
            self.end.send(summary).unwrap();
            self.thread.join().unwrap()
        }
    }

    #[test]
    fn a_session_with_two_faults_reads_back() {
        let folder = folder("recorder");
        let (recording, boxed) = (folder.join("s.rec"), folder.join("s.box"));
        let mut desk = Desk::new(Some(recording.clone()), Some(boxed.clone()));
        desk.records.push(Record::Device(HELLO)).unwrap();
        desk.settle();
        (0..5).for_each(|tick| desk.tick(tick));
        desk.box_writer.hand_over(FAULT);
        desk.tick(5);
        desk.box_writer.hand_over(FAULT);
        let written = desk.finish(Summary { ticks: 6, ..Summary::default() });
        assert_eq!((written.dumps, written.dumps_left_out, written.unwritten), (2, 0, 0));

        let whole = "header, scene 0, scene 1024, scene 2048, device, tick 0, tick 1, tick 2, tick 3, tick 4, tick 5, end 6";
        assert_eq!(read(&recording).join(", "), whole);
        assert_eq!(read(&boxed).join(", "), "header, device, tick 0, tick 1, tick 2, tick 3, tick 4, fault");
        assert_eq!(read(&folder.join("s.box.2")).join(", "), "header, device, tick 5, fault");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn recordings_and_readers_may_begin_and_end_while_the_session_runs() {
        let folder = folder("orders");
        let path = folder.join("s.rec");
        let mut desk = Desk::new(None, None);
        desk.records.push(Record::Device(HELLO)).unwrap();
        desk.tick(0);
        desk.settle();
        assert!(!desk.rest_wanted.load(Ordering::Relaxed));
        desk.orders.begin(path.clone()).unwrap();
        assert!(desk.rest_wanted.load(Ordering::Relaxed));
        let again = desk.orders.begin(path.clone()).unwrap_err().to_string();
        assert!(again.contains("end it first"), "{again}");
        let slow = desk.orders.tap(2);
        desk.orders.end().unwrap();
        (1..4).for_each(|tick| desk.tick(tick));
        desk.settle();
        let mut first = slow.recv().unwrap().to_vec();
        assert_eq!(records(&mut first).last().unwrap(), "device");
        slow.recv().unwrap();
        assert!(!desk.orders.end().unwrap());
        desk.finish(Summary { ticks: 4, recorder_dropped: 5, ..Summary::default() });
        assert_eq!(read(&path)[4..].join(", "), "device, recording begun 1, recording ended 1");
        let rest: Vec<u8> = slow.iter().flat_map(|frames| frames.to_vec()).collect();
        // three ticks found no room; five records never came this far
        assert_eq!(records(&mut rest.clone()).join(", "), "lost 3, lost 5");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_session_that_goes_to_another_scene_goes_on_in_the_same_file() {
        let folder = folder("scenes");
        let path = folder.join("s.rec");
        let mut desk = Desk::new(Some(path.clone()), None);
        let other = Origin::new(1000, vec![8; 10].into());
        desk.orders.scene(vec![8; 10].into());
        desk.tick(0);
        desk.settle();
        for digest in [other.header.scene_digest, 99, origin().header.scene_digest] {
            desk.records.push(Record::Header(RecordHeader { scene_digest: digest, ..other.header })).unwrap();
            desk.tick(0);
        }
        desk.finish(Summary::default());
        let told = read(&path).join(", ");
        let scene = "header, scene 0, scene 1024, scene 2048, tick 0, ";
        assert_eq!(told, format!("{scene}header, scene 0, tick 0, header, tick 0, {scene}end 0"));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_recording_that_cannot_be_created_is_named() {
        let error = Recorder::create(origin(), Some("/nowhere/s.rec".into()), None).unwrap_err();
        assert!(error.to_string().starts_with("cannot create the recording /nowhere/s.rec: "), "{error}");
    }
}
