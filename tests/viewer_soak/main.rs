//! `viewer-soak`: whether viewers can be seen in the times of a session.
//!
//! A host with a simulated device runs for some minutes. Half of the time nobody looks; in the other half, in turns of ten seconds, so that whatever else the machine
//! does hits both, one viewer attaches and detaches every second, taking what it can get, and another subscribes to everything and hardly reads. The recording then
//! tells tick by tick how late the thread woke, how long the step took and how long the round trip; printed are the quantiles of both halves and their ratio.
//!
//! `cargo build --release -p haptor-host -p haptor-firmware-sim && cargo run --release -p haptor-tests --bin viewer-soak -- MINUTES [FOLDER OF THE PROGRAMS]`

#[allow(dead_code, reason = "tests play more than this looks at")]
#[path = "../support/viewer.rs"]
mod viewer;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use haptor_host::viewer::listen::ViewerAddress;
use haptor_wire::{
    BakedScene, FromViewer, ObjectShape, Place, Record, RecordReader, RestBegin, RestPoints, TickRecord, ToViewer,
};
use viewer::{TestViewer, file};

/// Length of a turn: long enough for ten attachments, short enough that both halves meet the same machine.
const TURN: Duration = Duration::from_secs(10);

/// Ticks at the edges of a turn that count for neither half.
const EDGE_TICKS: u64 = 300;

fn main() {
    let mut args = std::env::args().skip(1);
    let minutes = args.next().and_then(|text| text.parse().ok()).filter(|&minutes: &f64| minutes > 0.0 && minutes < 1.0e4);
    let Some(minutes) = minutes else {
        eprintln!("usage: viewer-soak MINUTES [FOLDER OF THE PROGRAMS]");
        std::process::exit(2);
    };
    let folder = args.next().map_or_else(beside, PathBuf::from);
    let work = tempfile::tempdir().expect("a folder");
    let (model, record) = (work.path().join("scene.model"), work.path().join("session.haptor"));
    std::fs::write(&model, file(&scene())).expect("a file");
    let seconds = 60.0 * minutes;
    let (mut device, port) = device(&folder, seconds);
    let (mut host, address) = host(&folder, &model, &port, &record, seconds);
    let first = tick_now(&address);
    let turns = (seconds / TURN.as_secs_f64()) as u64;
    for turn in 0..turns.saturating_sub(1) {
        let end = first.1 + TURN * u32::try_from(turn + 1).expect("a few thousand");
        if turn % 2 == 1 { crowd(&address, end) } else { thread::sleep(end.saturating_duration_since(Instant::now())) }
    }
    let ended = host.wait().expect("the host ends");
    let _ = device.kill().and_then(|()| device.wait());
    let bytes = std::fs::read(&record).expect("a recording").leak();
    report(bytes, first.0);
    assert!(ended.code().is_some(), "the host ended with {ended}");
}

/// The folder of this program.
fn beside() -> PathBuf {
    std::env::current_exe().expect("a path").parent().expect("a folder").to_owned()
}

/// The ball on the rubber cube, two patches short of the hardest scene but with the whole surface to show.
fn scene() -> BakedScene {
    let place = Place { p_wd: [0.0, 0.0, 0.125], q_wd: [1.0, 0.0, 0.0, 0.0] };
    BakedScene { place, ..BakedScene::ball_on(ObjectShape::Box { size: [0.1; 3] }) }
}

fn device(folder: &Path, seconds: f64) -> (Child, String) {
    let mut child = Command::new(folder.join("haptor-firmware-sim"))
        .args(["--serve", "pty", "--preset", "premium15", "--script", "press-twist-slide", "--watchdog-ms", "200"])
        .args(["--seconds", &(seconds + 20.0).to_string()])
        .stdout(Stdio::piped())
        .spawn()
        .expect("haptor-firmware-sim lies in the folder");
    let output: ChildStdout = child.stdout.take().expect("piped");
    let port = line_after(BufReader::new(output), "serving pty ");
    (child, port)
}

fn host(folder: &Path, model: &Path, port: &str, record: &Path, seconds: f64) -> (Child, ViewerAddress) {
    let mut child = Command::new(folder.join("haptor-host"))
        .arg(model)
        .args(["--device", &format!("serial:{port}"), "--rt", "ignore", "--hold", "50", "--fade", "100"])
        .args(["--seconds", &seconds.to_string(), "--viewer", "127.0.0.1:0", "--record"])
        .arg(record)
        .stderr(Stdio::piped())
        .spawn()
        .expect("haptor-host lies in the folder");
    let errors: ChildStderr = child.stderr.take().expect("piped");
    let address = line_after(BufReader::new(errors), "viewers come in at ");
    (child, address.parse().expect("an address"))
}

/// What follows `mark` in the first line that has it; what comes later is passed on.
fn line_after(mut lines: impl BufRead + Send + 'static, mark: &str) -> String {
    loop {
        let mut line = String::new();
        assert!(lines.read_line(&mut line).expect("text") > 0, "the program ended without saying `{mark}`");
        if let Some((_, rest)) = line.split_once(mark) {
            thread::spawn(move || lines.lines().map_while(Result::ok).for_each(|line| eprintln!("{line}")));
            return rest.trim().to_owned();
        }
    }
}

/// The tick of the moment.
fn tick_now(address: &ViewerAddress) -> (u64, Instant) {
    let mut viewer = TestViewer::connect(address).enter();
    viewer.subscribe(1, 0, 0);
    let tick = viewer.wait_for("a snapshot", |message| match message {
        ToViewer::Snapshot(snapshot) => Some(snapshot.tick),
        _ => None,
    });
    (tick, Instant::now())
}

/// A turn with viewers.
fn crowd(address: &ViewerAddress, end: Instant) {
    let over = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            let mut slow = TestViewer::connect(address).enter();
            watch_surface(&mut slow);
            slow.subscribe(1, 1, 10);
            while !over.load(Ordering::Relaxed) {
                thread::sleep(Duration::from_secs(1));
                slow.hear();
                slow.heard.clear();
            }
        });
        while Instant::now() < end {
            let next = (Instant::now() + Duration::from_secs(1)).min(end);
            let mut quick = TestViewer::connect(address).enter();
            watch_surface(&mut quick);
            quick.subscribe(16, 1, 100);
            while Instant::now() < next {
                thread::sleep(Duration::from_millis(16));
                quick.hear();
                quick.heard.clear();
            }
        }
        over.store(true, Ordering::Relaxed);
    });
}

/// A thousand points along the cube's height.
fn watch_surface(viewer: &mut TestViewer) {
    viewer.say(&FromViewer::RestBegin(RestBegin { count: 1000 }));
    for i in 0..4 {
        let points = (0..250).map(|k| [0.0, 0.0, 1.0e-4 * (250 * i + k) as f32]).collect();
        viewer.say(&FromViewer::RestPoints(RestPoints { offset: 250 * i, points }));
    }
}

/// Quantiles of the ticks with and without viewers.
fn report(recording: &'static mut [u8], first: u64) {
    let turn_ticks = TURN.as_millis() as u64;
    let (mut alone, mut crowded, mut late) = (Vec::new(), Vec::new(), [0_u64; 2]);
    for record in RecordReader::new(recording) {
        match record.expect("a whole recording") {
            Record::Tick(tick) if tick.tick >= first => {
                let (turn, within) = ((tick.tick - first) / turn_ticks, (tick.tick - first) % turn_ticks);
                if (EDGE_TICKS..turn_ticks - EDGE_TICKS).contains(&within) {
                    late[(turn % 2) as usize] += u64::from(tick.flags & haptor_wire::flags::LATE != 0);
                    if turn % 2 == 1 { crowded.push(tick) } else { alone.push(tick) }
                }
            }
            Record::Fault(fault) => println!("fault: {} in tick {}", fault.cause.name(), fault.tick),
            _ => {}
        }
    }
    println!("{} ticks alone ({} late), {} with viewers ({} late)", alone.len(), late[0], crowded.len(), late[1]);
    type Time = fn(&TickRecord) -> u32;
    let times: [(&str, Time); 3] = [("wake-up", |t| t.wake_ns), ("step", |t| t.step_ns), ("round trip", |t| t.round_trip_ns)];
    println!("{:<12} {:>10} {:>12} {:>12} {:>8}", "[us]", "quantile", "alone", "viewers", "ratio");
    for (name, time) in times {
        for share in [0.5, 0.99, 0.999, 0.9999] {
            let [a, b] = [&alone, &crowded].map(|ticks| quantile(ticks.iter().map(time).filter(|&ns| ns > 0).collect(), share));
            println!("{name:<12} {share:>10} {:>12.1} {:>12.1} {:>8.3}", a / 1000.0, b / 1000.0, b / a);
        }
    }
}

fn quantile(mut ns: Vec<u32>, share: f64) -> f64 {
    ns.sort_unstable();
    let at = ((ns.len() as f64 * share) as usize).min(ns.len().saturating_sub(1));
    ns.get(at).map_or(f64::NAN, |&ns| f64::from(ns))
}
