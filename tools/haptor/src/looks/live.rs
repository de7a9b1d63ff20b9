//! A running host as a source of pictures: a thread listens to the viewer link and the window takes what has come.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use haptor_engine::{Scene, SceneError};
use haptor_viewer::Vec3;
use haptor_viewer::feed::{
    Command, Displacement, Event, Frame, Mode, News, Pose, Region, Sample, Severity, Source, Stage, Timing, Wrench,
};
use haptor_wire::{OutputState, PatchLook, Snapshot, Subscription, SurfaceBlock, ToViewer, Wish};

use super::stage;
use super::words::{fault, flag_words, rotation, wide};
use crate::client::{self, ClientError, Viewer};
use crate::skins;

/// Snapshots a second that are asked for: the plots then have a point for every pixel of some seconds.
const SNAPSHOTS_HZ: u32 = 250;

/// Every so many snapshots comes a surface: 62 a second, as a screen shows.
const SURFACE_EVERY: u32 = 4;

/// How long the thread waits for the host before it looks what the window wants \[ms\]: a person does not notice.
const WAIT: Duration = Duration::from_millis(5);

/// Samples and events kept for a window that does not look; the oldest go.
const KEPT: usize = 20_000;

/// A running host to look at.
#[derive(Debug)]
pub struct Live {
    news: Arc<Mutex<News>>,
    commands: Sender<Command>,
}

impl Live {
    /// Looks at the host that `viewer` is connected to, called `name`.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn new(viewer: Viewer, name: String) -> std::io::Result<Self> {
        let news = Arc::new(Mutex::new(News::default()));
        let (commands, wanted) = mpsc::channel();
        let listener = Listener {
            viewer,
            name,
            news: Arc::clone(&news),
            wanted,
            frame: Frame::default(),
            surface: Surface::default(),
            recording: None,
            rate_hz: 0,
        };
        // not joined: it ends when the window has gone
        thread::Builder::new().name("looks".into()).spawn(move || listener.run())?;
        Ok(Self { news, commands })
    }
}

impl Source for Live {
    fn poll(&mut self, _now: Duration) -> News {
        std::mem::take(&mut self.news.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn send(&mut self, command: Command) {
        // a listener that is gone has said so
        let _ = self.commands.send(command);
    }
}

/// The thread that listens.
struct Listener {
    viewer: Viewer,
    name: String,
    news: Arc<Mutex<News>>,
    wanted: Receiver<Command>,
    frame: Frame,
    surface: Surface,
    recording: Option<Recording>,
    rate_hz: u32,
}

/// A recording that is being received.
struct Recording {
    path: PathBuf,
    file: BufWriter<File>,
}

/// A surface whose blocks are coming in.
#[derive(Default)]
struct Surface {
    tick: u64,
    moved: Vec<Vec3>,
}

impl Surface {
    /// Takes a block; yields the surface when it is whole. One with a gap is never whole.
    fn take(&mut self, block: &SurfaceBlock) -> Option<Displacement> {
        if block.offset == 0 {
            self.tick = block.tick;
            self.moved.clear();
        }
        if block.tick != self.tick || block.offset as usize != self.moved.len() {
            return None;
        }
        self.moved.extend(block.displacements().map(Vec3::from_array));
        (self.moved.len() == block.of as usize).then(|| Displacement { tick: self.tick, moved: self.moved.as_slice().into() })
    }
}

impl Listener {
    fn run(mut self) {
        self.begin();
        loop {
            match self.wanted.try_recv() {
                Ok(command) => self.obey(command),
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => return,
            }
            match self.viewer.next(WAIT) {
                Ok(None) => {}
                Ok(Some(client::News::Message(message))) => self.hear(message),
                Ok(Some(client::News::Connected)) => {
                    self.tell(Severity::Info, "connected again".to_owned());
                    self.begin();
                }
                Ok(Some(client::News::Lost(error))) => self.gone(&error),
                Err(error) => return self.gone(&error),
            }
        }
    }

    /// On every new connection: what is wanted.
    fn begin(&mut self) {
        let Some(connection) = self.viewer.connection() else { return };
        self.rate_hz = connection.welcome().rate_hz;
        let every = (self.rate_hz / SNAPSHOTS_HZ).max(1);
        self.viewer.subscribe(Subscription { every, surface: SURFACE_EVERY, statistics_ms: 0 });
    }

    fn hear(&mut self, message: ToViewer) {
        match message {
            ToViewer::Scene(_) => self.set_stage(),
            ToViewer::Snapshot(snapshot) => self.show(&snapshot),
            ToViewer::Surface(block) => {
                if let Some(whole) = self.surface.take(&block) {
                    self.frame.displacement = Some(whole);
                }
            }
            ToViewer::Fault(record) => {
                let told = fault(record.cause);
                self.tell(Severity::Fault, format!("{}: {}", told.what, told.advice));
            }
            ToViewer::Event(event) => self.tell(Severity::Info, event.what.name().to_owned()),
            ToViewer::Denied(denied) => self.tell(Severity::Warning, denied.to_string()),
            ToViewer::RecordBytes(piece) => self.keep(&piece.bytes),
            ToViewer::End(summary) => {
                self.end_recording();
                self.frame.mode = Mode::Disconnected;
                self.tell(Severity::Info, format!("the session has ended after {} ticks", summary.ticks));
            }
            _ => {}
        }
    }

    fn set_stage(&mut self) {
        let built = self.download().and_then(|file| looks(&file, &self.name, self.rate_hz).map_err(|error| error.to_string()));
        let built = built.and_then(|stage| {
            let points = stage.object.vertices.iter().map(|v| v.as_vec3().to_array()).collect();
            self.viewer.watch_points(points).map_err(|error| error.to_string())?;
            Ok(stage)
        });
        match built {
            Ok(stage) => {
                (self.surface, self.frame.displacement) = (Surface::default(), None);
                self.with_news(|news| *news = News { stage: Some(Arc::new(stage)), ..News::default() });
            }
            Err(what) => self.tell(Severity::Warning, format!("the scene cannot be shown: {what}")),
        }
    }

    fn download(&mut self) -> Result<Vec<u8>, String> {
        let connection = self.viewer.connection().ok_or_else(|| "the connection was lost".to_owned())?;
        connection.download().map_err(|error: ClientError| error.to_string())
    }

    fn show(&mut self, snapshot: &Snapshot) {
        let recording = self.recording.is_some();
        let displacement = self.frame.displacement.take();
        self.frame = Frame { displacement, recording, ..frame(snapshot) };
        let (frame, sample) = (Arc::new(self.frame.clone()), sample(snapshot));
        self.with_news(|news| {
            news.frame = Some(frame);
            news.samples.push(sample);
            if news.samples.len() > KEPT {
                news.samples.drain(..KEPT / 2);
            }
        });
    }

    fn gone(&mut self, error: &ClientError) {
        self.end_recording();
        self.frame.mode = Mode::Disconnected;
        self.frame.recording = false;
        let frame = Arc::new(self.frame.clone());
        self.with_news(|news| news.frame = Some(frame));
        self.tell(Severity::Warning, error.to_string());
    }

    fn obey(&mut self, command: Command) {
        let wish = match command {
            Command::Record(true) => return self.begin_recording(),
            Command::Record(false) => Wish::Record(false),
            Command::Freeze(frozen) => Wish::Freeze(frozen),
            Command::Tare => Wish::Tare,
            Command::EStop => Wish::EStop,
            Command::Rearm => Wish::Rearm,
            Command::Seek(_) | Command::Play(_) | Command::Speed(_) => return,
        };
        self.viewer.ask(wish);
        if command == Command::Record(false) {
            self.end_recording();
        }
    }

    fn begin_recording(&mut self) {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let path = PathBuf::from(format!("session-{}.haptor", since_1970.as_secs()));
        match File::create_new(&path) {
            Ok(file) => {
                self.viewer.ask(Wish::Record(true));
                self.tell(Severity::Info, format!("recording to {}", path.display()));
                self.recording = Some(Recording { path, file: BufWriter::new(file) });
            }
            Err(error) => self.tell(Severity::Warning, format!("{}: cannot be created: {error}", path.display())),
        }
    }

    fn keep(&mut self, bytes: &[u8]) {
        let Some(recording) = &mut self.recording else { return };
        if let Err(error) = recording.file.write_all(bytes) {
            let what = format!("{}: cannot be written: {error}; the recording ends", recording.path.display());
            self.recording = None;
            self.viewer.ask(Wish::Record(false));
            self.tell(Severity::Warning, what);
        }
    }

    fn end_recording(&mut self) {
        let Some(mut recording) = self.recording.take() else { return };
        let path = recording.path.display().to_string();
        match recording.file.flush() {
            Ok(()) => self.tell(Severity::Info, format!("{path} written")),
            Err(error) => self.tell(Severity::Warning, format!("{path}: cannot be written: {error}")),
        }
    }

    fn tell(&self, severity: Severity, words: String) {
        let time = self.frame.time;
        self.with_news(|news| {
            news.events.push(Event { time, severity, words });
            if news.events.len() > KEPT {
                news.events.drain(..KEPT / 2);
            }
        });
    }

    fn with_news(&self, change: impl FnOnce(&mut News)) {
        change(&mut self.news.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

/// The stage of a baked file.
fn looks(file: &[u8], name: &str, rate_hz: u32) -> Result<Stage, SceneError> {
    let skins = skins::read(file)?;
    stage(&Scene::read(file)?, &skins, name, rate_hz)
}

fn frame(snapshot: &Snapshot) -> Frame {
    Frame {
        tick: snapshot.tick,
        time: snapshot.t_us as f64 / 1.0e6,
        probe: Pose { position: wide(snapshot.position), rotation: rotation(snapshot.rotation) },
        contact: Wrench { force: wide(snapshot.contact_force), torque: wide(snapshot.contact_torque) },
        sent: Some(Wrench { force: wide(snapshot.sent_force), torque: wide(snapshot.sent_torque) }),
        regions: snapshot.patches.iter().map(region).collect(),
        depth: snapshot.depth.into(),
        tier: snapshot.tier.name().to_owned(),
        flags: flag_words(snapshot.flags),
        timing: Some(Timing {
            step_us: f64::from(snapshot.step_ns) / 1.0e3,
            wake_us: f64::from(snapshot.wake_ns) / 1.0e3,
            in_time: f64::from(snapshot.in_time_permille) / 1.0e3,
        }),
        fault: snapshot.fault.map(fault),
        mode: match snapshot.output {
            OutputState::Open | OutputState::Closed => Mode::Running,
            OutputState::Frozen => Mode::Frozen,
            OutputState::Stopped => Mode::Braked,
        },
        ..Frame::default()
    }
}

/// A patch as a window shows it.
fn region(patch: &PatchLook) -> Region {
    Region {
        centre: wide(patch.centre),
        normal: wide(patch.normal),
        radius: patch.radius.into(),
        stick_radius: patch.stick_radius.into(),
        force: wide(patch.force),
        torque: wide(patch.torque),
        pressure: None,
    }
}

fn sample(snapshot: &Snapshot) -> Sample {
    Sample {
        time: snapshot.t_us as f64 / 1.0e6,
        force: wide(snapshot.contact_force),
        torque: wide(snapshot.contact_torque),
        depth: snapshot.depth.into(),
        step_us: f64::from(snapshot.step_ns) / 1.0e3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(tick: u64, offset: u32, points: usize) -> SurfaceBlock {
        let mut block = SurfaceBlock { tick, of: 5, offset, step: 1.0e-6, moved: heapless::Vec::new() };
        (0..points).for_each(|i| block.moved.push([offset as i16 + i as i16, 0, -1]).unwrap());
        block
    }

    #[test]
    fn a_surface_is_shown_when_all_its_blocks_have_come() {
        let mut surface = Surface::default();
        assert!(surface.take(&block(4, 0, 3)).is_none());
        let whole = surface.take(&block(4, 3, 2)).unwrap();
        assert_eq!((whole.tick, whole.moved.len(), whole.moved[4].x), (4, 5, 4.0e-6));
        // a block of another tick, or one that is missing, leaves the old surface
        assert!(surface.take(&block(8, 3, 2)).is_none());
        assert!(surface.take(&block(9, 0, 2)).is_none());
        assert!(surface.take(&block(9, 3, 2)).is_none());
        assert!(surface.take(&block(10, 0, 5)).is_some());
    }
}
