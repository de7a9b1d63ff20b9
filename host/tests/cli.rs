//! The binary as a user or a tool meets it: exit codes, what it says, what it leaves behind.

use std::fs;
use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use haptor_wire::recording::RecordReader;
use haptor_wire::scene_file::{FILE_MAX, encode_file};
use haptor_wire::{BakedScene, FromHost, HostFault, ObjectShape, Record, StreamDecoder, Tier, stream_bound};

/// A folder of one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("haptor-host-cli-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// A baked ball on a half space.
    fn model(&self, tier: Tier) -> String {
        let scene = BakedScene { tier, ..BakedScene::ball_on(ObjectShape::HalfSpace) };
        let mut file = [0; FILE_MAX];
        let n = encode_file(&scene, &mut file).unwrap();
        self.file("good.model", &file[..n])
    }

    fn file(&self, name: &str, bytes: &[u8]) -> String {
        let path = self.0.join(name);
        fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn host(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_haptor-host")).args(args).output().unwrap()
}

/// A host whose standard input this program holds.
fn tied_host(args: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_haptor-host"));
    command.args(args).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn bad_usage_and_bad_input_exit_2_and_write_nothing() {
    let folder = Folder::new("input");
    let (good, not_one) = (folder.model(Tier::Bristle), folder.file("not.model", b"[object]\nshape = \"box\"\n"));
    let (record, missing) = (folder.path("s.rec"), folder.path("missing.model"));
    let device = "tcp:127.0.0.1:9";
    let table: [(&[&str], &str); 7] = [
        (&[], "Usage"),
        (&[&good], "--device"),
        (&[&good, "--device", "can:0"], "allowed: serial:PATH"),
        (&[&good, "--device", device, "--rate", "0", "--record", &record], "--rate is 0; allowed is 100 to 8000 Hz"),
        (&[&missing, "--device", device, "--record", &record], "cannot read the baked scene"),
        (&[&not_one, "--device", device, "--record", &record], "not a baked scene"),
        (&[&good, "--device", device, "--seconds", "-1", "--record", &record], "--seconds"),
    ];
    for (args, named) in table {
        let output = host(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(named), "{args:?} says {}", stderr(&output));
        assert!(output.stdout.is_empty());
    }
    let green = folder.model(Tier::Green);
    let output = host(&[&green, "--device", device, "--record", &record]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("carries no table"), "{}", stderr(&output));
    assert!(!PathBuf::from(record).exists());
}

#[test]
fn a_device_that_is_not_there_exits_1_and_is_named() {
    let folder = Folder::new("absent");
    let (model, record) = (folder.model(Tier::Point), folder.path("s.rec"));
    for device in ["serial:/dev/no-such-port", "tcp:127.0.0.1:1", "usb:no-such-number", "usb-bulk:no-such-number"] {
        let output = host(&[&model, "--device", device, "--rt", "ignore", "--record", &record]);
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(&format!("cannot open {device}: ")), "{}", stderr(&output));
    }
    assert!(!PathBuf::from(record).exists());
}

#[test]
fn a_start_that_is_refused_leaves_an_older_recording_alone() {
    let folder = Folder::new("refused");
    let (model, record) = (folder.model(Tier::Point), folder.file("s.rec", b"older"));
    let (device, served) = strange_device(b"");
    // no machine has a CPU of that number
    let output = host(&[&model, "--device", &device, "--rt", "enforce", "--cpu", "1023", "--record", &record]);
    drop(served.join());
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("real-time start refused: "), "{}", stderr(&output));
    assert_eq!(fs::read(record).unwrap(), b"older");
}

#[test]
fn a_recording_that_cannot_be_created_ends_the_session() {
    let folder = Folder::new("unwritable");
    let (model, device) = (folder.model(Tier::Point), strange_device(b""));
    let output = host(&[&model, "--device", &device.0, "--rt", "ignore", "--record", "/no-such-folder/s.rec"]);
    drop(device.1.join());
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("cannot create the recording /no-such-folder/s.rec: "), "{}", stderr(&output));
}

#[test]
fn a_host_tied_to_its_standard_input_ends_with_it_and_its_recording_is_whole() {
    let folder = Folder::new("tied");
    let (model, record) = (folder.model(Tier::Point), folder.path("s.rec"));
    // takes the connection and says nothing for as long as the test runs
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let device = format!("tcp:{}", listener.local_addr().unwrap());
    let mut host = tied_host(&[&model, "--device", &device, "--rt", "ignore", "--record", &record, "--until-stdin-closes"]);
    let stream = listener.accept().unwrap();
    let began = Instant::now();
    let patient = || {
        assert!(began.elapsed() < Duration::from_secs(20), "the host hangs");
        std::thread::sleep(Duration::from_millis(5));
    };
    while !PathBuf::from(&record).exists() {
        patient();
    }
    assert!(host.try_wait().unwrap().is_none(), "it runs while it is held");
    drop(host.stdin.take());
    while host.try_wait().unwrap().is_none() {
        patient();
    }
    drop(stream);
    let mut file = fs::read(record).unwrap();
    assert!(matches!(RecordReader::new(&mut file).last(), Some(Ok(Record::End(_)))));
}

/// A device that takes the connection, keeps it for a while and says `words`.
fn strange_device(words: &'static [u8]) -> (String, std::thread::JoinHandle<Option<TcpStream>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp:{}", listener.local_addr().unwrap());
    let serve = move || {
        let (mut stream, _) = listener.accept().ok()?;
        for _ in 0..200 {
            stream.write_all(words).ok()?;
        }
        Some(stream)
    };
    (address, std::thread::spawn(serve))
}

#[test]
fn a_device_that_talks_nonsense_exits_1_names_it_and_leaves_readable_files() {
    let folder = Folder::new("nonsense");
    let (model, record) = (folder.model(Tier::Point), folder.path("s.rec"));
    let (device, served) = strange_device(b"GET / HTTP/1.1\r\n\0");
    let args = [&model, "--device", &device, "--rt", "ignore", "--record", &record, "--status", "frames", "--seconds", "60"];
    let output = host(&args);
    drop(served.join());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("fault: garbage on the link"), "{}", stderr(&output));

    let mut told = Vec::new();
    StreamDecoder::<{ stream_bound(FromHost::MAX_ENCODED) }>::new().feed(&output.stdout, |message: FromHost| told.push(message));
    assert!(matches!(told[0], FromHost::Fault(fault) if fault.cause == HostFault::Garbage), "{told:?}");
    assert!(
        matches!(told.last(), Some(FromHost::Summary(s)) if s.fault == Some(HostFault::Garbage) && s.rejected > 0),
        "{told:?}"
    );

    let mut file = fs::read(record).unwrap();
    let records = RecordReader::new(&mut file).map(Result::unwrap);
    let records: Vec<Record<'_>> = records.filter(|r| !matches!(r, Record::Schema(_) | Record::Scene(_))).collect();
    assert!(matches!(records[..], [Record::Header(_), Record::Fault(_), Record::End(_)]), "{records:?}");
    let mut boxed = fs::read(folder.path("s.rec.blackbox")).unwrap();
    assert!(RecordReader::new(&mut boxed).any(|r| matches!(r, Ok(Record::Fault(_)))));
}
