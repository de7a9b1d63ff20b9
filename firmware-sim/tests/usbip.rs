//! The device on its USB cable, without a kernel: this file speaks USB/IP over TCP as `usbip attach` and `vhci-hcd` do, reads what the device says
//! it is, plays a session, and then misbehaves.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use haptor_wire::usb::{BULK, Endpoints, INTERRUPT, PRODUCT_ID, VENDOR_ID};
use haptor_wire::{
    FromDevice, HostHello, Mode, PROTOCOL_VERSION, PoseReport, SCHEMA_HASH, ToDevice, WrenchCommand, decode_packet, encode_packet,
};

/// After this a device that says nothing is taken for hung, and the test fails.
const PATIENCE: Duration = Duration::from_secs(20);

/// Status of an endpoint that is halted, and of a transfer that was taken back.
const STALLED: i32 = -32;
const TAKEN_BACK: i32 = -104;

/// What this host calls it when the socket has closed.
const GONE: i32 = i32::MIN;

/// The process; killed when the test ends, however it ends.
struct Sim(Child, String);

impl Sim {
    fn start(args: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_haptor-firmware-sim"))
            .args(["--serve", "usbip:127.0.0.1:0", "--serial", "SN42", "--watchdog-ms", "8000"])
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let place = line.trim().strip_prefix("serving usbip ").unwrap().to_owned();
        Self(child, place)
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.1).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Asks for a device; its status, and the socket.
    fn import(&self, name: &[u8]) -> (u32, TcpStream) {
        let mut stream = self.connect();
        let mut field = [0; 32];
        field[..name.len()].copy_from_slice(name);
        stream.write_all(&[1, 0x11, 0x80, 3, 0, 0, 0, 0]).unwrap();
        stream.write_all(&field).unwrap();
        let head = take(&mut stream, 8);
        assert_eq!(head[..4], [1, 0x11, 0, 3]);
        let status = u32::from_be_bytes(head[4..].try_into().unwrap());
        if status == 0 {
            take(&mut stream, 312);
        }
        (status, stream)
    }

    fn attach(&self) -> Bus {
        // whoever had it before is let go a moment after it has closed
        loop {
            match self.import(b"1-1") {
                (0, stream) => return Bus { stream, seq: 0, pair: INTERRUPT, commands: 0 },
                (status, _) => assert!(matches!(status, 1 | 2), "{status}"),
            }
        }
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn take(stream: &mut TcpStream, bytes: usize) -> Vec<u8> {
    let mut data = vec![0; bytes];
    stream.read_exact(&mut data).unwrap();
    data
}

/// The host's side of the bus, one transfer at a time.
struct Bus {
    stream: TcpStream,
    seq: u32,
    pair: Endpoints,
    commands: u32,
}

impl Bus {
    fn submit(&mut self, address: u8, length: u32, setup: [u8; 8], data: &[u8]) -> u32 {
        self.seq += 1;
        let to_host = u32::from(address >> 7);
        let mut bytes: Vec<u8> = [1, self.seq, 0x10002, to_host, u32::from(address & 0x7F), 0, length, 0, 0, 0]
            .iter()
            .flat_map(|word: &u32| word.to_be_bytes())
            .collect();
        bytes.extend(setup);
        bytes.extend(data);
        // a socket that has closed says so when the answer is read
        let _ = self.stream.write_all(&bytes);
        self.seq
    }

    /// The next answer: number, status, bytes carried.
    fn answer(&mut self) -> (u32, i32, usize) {
        let mut header = [0; 48];
        if self.stream.read_exact(&mut header).is_err() {
            return (self.seq, GONE, 0);
        }
        let word = |at: usize| u32::from_be_bytes(header[4 * at..4 * at + 4].try_into().unwrap());
        (word(1), word(5) as i32, word(6) as usize)
    }

    fn fetch(&mut self, address: u8, length: u32, setup: [u8; 8]) -> Result<Vec<u8>, i32> {
        let seq = self.submit(address, length, setup, &[]);
        match self.answer() {
            (answered, 0, carried) if answered == seq => Ok(take(&mut self.stream, carried)),
            (_, status, _) => Err(status),
        }
    }

    fn bring(&mut self, address: u8, setup: [u8; 8], data: &[u8]) -> Result<(), i32> {
        let seq = self.submit(address, data.len() as u32, setup, data);
        let (answered, status, _) = self.answer();
        assert_eq!(answered, seq);
        if status == 0 { Ok(()) } else { Err(status) }
    }

    fn descriptor(&mut self, kind: u8, index: u8, length: u32) -> Result<Vec<u8>, i32> {
        self.fetch(0x80, length, [0x80, 6, index, kind, 0, 0, length as u8, (length >> 8) as u8])
    }

    fn clear_halt(&mut self, address: u8) {
        self.bring(0, [2, 1, 0, 0, address, 0, 0, 0], &[]).unwrap();
    }

    fn say(&mut self, message: &ToDevice) -> Result<(), i32> {
        self.bring(self.pair.to_device, [0; 8], &encode_packet(message).unwrap())
    }

    fn hear(&mut self) -> Result<FromDevice, i32> {
        self.fetch(self.pair.to_host, 64, [0; 8]).map(|packet| decode_packet(&packet).unwrap())
    }

    /// Reset, hello, force; the device's serial number by its hello. Reports of an older session may push an answer out of the queue, so a hello
    /// is repeated.
    fn try_open(&mut self) -> Result<String, i32> {
        self.say(&ToDevice::SetMode(Mode::Reset))?;
        loop {
            self.say(&ToDevice::Hello(HostHello { version: PROTOCOL_VERSION, schema: SCHEMA_HASH, period_us: 1000 }))?;
            for _ in 0..20 {
                if let FromDevice::Hello(hello) = self.hear()? {
                    self.say(&ToDevice::SetMode(Mode::Force))?;
                    return Ok(hello.serial_chars().collect());
                }
            }
        }
    }

    fn open(&mut self) -> String {
        self.try_open().unwrap()
    }

    /// The next report, answered.
    fn pose(&mut self) -> Result<PoseReport, i32> {
        loop {
            if let FromDevice::Pose(pose) = self.hear()? {
                self.commands += 1;
                let (seq, echo) = (self.commands, pose.seq);
                let command = WrenchCommand { seq, echo, force_un: [0; 3], torque_unm: [0; 3], hold_us: 5000 };
                self.say(&ToDevice::Wrench(command))?;
                return Ok(pose);
            }
        }
    }
}

#[test]
fn it_is_listed_and_given_to_one_host_at_a_time() {
    let sim = Sim::start(&[]);
    let mut stream = sim.connect();
    stream.write_all(&[1, 0x11, 0x80, 5, 0, 0, 0, 0]).unwrap();
    let list = take(&mut stream, 12 + 312 + 4);
    assert_eq!((&list[..12], &list[268..271]), (&[1, 0x11, 0, 5, 0, 0, 0, 0, 0, 0, 0, 1][..], &b"1-1"[..]));
    let numbers = &list[12 + 256 + 32 + 12..];
    assert_eq!((&numbers[..2], &numbers[2..4]), (&VENDOR_ID.to_be_bytes()[..], &PRODUCT_ID.to_be_bytes()[..]));
    assert_eq!(list[12 + 312..], [0xFF, 0x48, 1, 0]);
    let (first, held) = sim.import(b"1-1");
    assert_eq!((first, sim.import(b"1-1").0, sim.import(b"9-9").0), (0, 2, 4));
    drop(held);
    sim.attach();
}

#[test]
fn it_says_what_it_is() {
    let sim = Sim::start(&[]);
    let mut bus = sim.attach();
    let device = bus.descriptor(1, 0, 18).unwrap();
    assert_eq!((device.len(), &device[2..4], &device[8..12]), (18, &[0x10, 2][..], &[0x09, 0x12, 1, 0][..]));
    let config = bus.descriptor(2, 0, 9).unwrap();
    let total = u32::from(u16::from_le_bytes([config[2], config[3]]));
    let config = bus.descriptor(2, 0, 512).unwrap();
    assert_eq!((config.len() as u32, &config[14..17]), (total, &[0xFF, 0x48, 1][..]));
    let endpoints: Vec<_> = config[18..].chunks(7).map(|e| (e[2], e[3], u16::from_le_bytes([e[4], e[5]]), e[6])).collect();
    assert_eq!(endpoints, [(0x01, 3, 64, 1), (0x81, 3, 64, 1), (0x02, 2, 512, 0), (0x82, 2, 512, 0)]);
    let text = |bytes: Vec<u8>| -> String {
        char::decode_utf16(bytes[2..].chunks(2).map(|unit| u16::from_le_bytes([unit[0], unit[1]]))).map(Result::unwrap).collect()
    };
    assert_eq!(bus.descriptor(3, 0, 255).unwrap(), [4, 3, 9, 4]);
    let strings: Vec<_> = (1..=4).map(|index| text(bus.descriptor(3, index, 255).unwrap())).collect();
    assert_eq!(strings, ["haptor", "simulated haptic device", "SN42", "haptor device link"]);
    let bos = bus.descriptor(15, 0, 255).unwrap();
    let (vendor_code, length) = (bos[31], u16::from_le_bytes([bos[29], bos[30]]));
    let set = bus.fetch(0x80, 512, [0xC0, vendor_code, 0, 0, 7, 0, 0, 2]).unwrap();
    assert_eq!((set.len(), &set[14..20]), (usize::from(length), &b"WINUSB"[..]));
    // what it does not have, it stalls: a device qualifier, a fifth string, a request of nobody's
    assert_eq!(bus.descriptor(6, 0, 10), Err(STALLED));
    assert_eq!(bus.descriptor(3, 5, 255), Err(STALLED));
    assert_eq!(bus.fetch(0x80, 8, [0xC0, 0x77, 0, 0, 0, 0, 8, 0]), Err(STALLED));
    bus.bring(0, [0, 9, 1, 0, 0, 0, 0, 0], &[]).unwrap();
    assert_eq!(bus.fetch(0x80, 1, [0x80, 8, 0, 0, 0, 0, 1, 0]), Ok(vec![1]));
}

#[test]
fn a_session_over_either_pair_of_endpoints() {
    let sim = Sim::start(&["--preset", "sigma7"]);
    for pair in [INTERRUPT, BULK] {
        let mut bus = sim.attach();
        bus.pair = pair;
        assert_eq!(bus.open(), "SN42");
        let first = bus.pose().unwrap();
        let last = (0..300).map(|_| bus.pose().unwrap()).last().unwrap();
        assert_eq!((last.mode, last.flags), (Mode::Force, 0), "{pair:?}");
        assert!(last.seq >= first.seq + 300 && last.echo > 250, "{pair:?}: {last:?}");
    }
}

#[test]
fn a_transfer_that_waits_can_be_taken_back() {
    let sim = Sim::start(&[]);
    let mut bus = sim.attach();
    let victim = bus.submit(INTERRUPT.to_host, 64, [0; 8], &[]);
    for (of, status) in [(victim, TAKEN_BACK), (victim, 0), (4_000_000_000, 0)] {
        bus.seq += 1;
        let words = [2, bus.seq, 0x10002, 0, 0, of, 0, 0, 0, 0, 0, 0];
        let bytes: Vec<u8> = words.iter().flat_map(|word: &u32| word.to_be_bytes()).collect();
        bus.stream.write_all(&bytes).unwrap();
        assert_eq!(bus.answer(), (bus.seq, status, 0), "{of}");
    }
    bus.open();
    bus.pose().unwrap();
}

#[test]
fn halted_endpoints_stall_until_they_are_cleared() {
    let sim = Sim::start(&["--fault", "halt@0.05:1ms"]);
    let mut bus = sim.attach();
    bus.open();
    let status = loop {
        if let Err(status) = bus.pose() {
            break status;
        }
    };
    assert_eq!(status, STALLED);
    bus.clear_halt(INTERRUPT.to_device);
    bus.clear_halt(INTERRUPT.to_host);
    for _ in 0..50 {
        bus.pose().unwrap();
    }
}

/// Runs the loop until the cable is pulled; the number of the last report.
fn until_pulled(bus: &mut Bus) -> u32 {
    let mut last = 0;
    loop {
        match bus.pose() {
            Ok(pose) => last = pose.seq,
            Err(GONE) => return last,
            Err(_) => {}
        }
    }
}

#[test]
fn an_unplugged_device_is_gone_and_comes_back() {
    let sim = Sim::start(&["--fault", "unplug@0.05:200ms", "--fault", "reboot@2:100ms"]);
    let mut last = 0;
    for anew in [false, false, true] {
        // a slow test may be pulled before it is through
        let (mut bus, seq) = loop {
            let mut bus = sim.attach();
            if let Ok(pose) = bus.try_open().and_then(|_| bus.pose()) {
                break (bus, pose.seq);
            }
        };
        // a firmware that began anew counts from 0, and has had no time yet to come as far as before
        assert_eq!(seq < last, anew, "{seq} after {last}");
        if !anew {
            last = until_pulled(&mut bus);
        }
    }
}

#[test]
fn what_is_no_usb_ip_costs_the_connection_and_nothing_else() {
    let sim = Sim::start(&[]);
    let header = |words: [u32; 12]| -> Vec<u8> { words.iter().flat_map(|word| word.to_be_bytes()).collect() };
    let hostile: Vec<Vec<u8>> = vec![
        header([9, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        // data of 4 GB announced
        header([1, 1, 0, 0, 1, 0, u32::MAX, 0, 0, 0, 0, 0]),
        // isochronous
        header([1, 1, 0, 1, 1, 0, 64, 0, 1000, 0, 0, 0]),
        header([1, 1, 0, 1, 200, 0, 64, 0, 0, 0, 0, 0]),
        header([u32::MAX; 12]),
    ];
    for bytes in &hostile {
        let (status, mut stream) = loop {
            match sim.import(b"1-1") {
                (2, _) => {}
                other => break other,
            }
        };
        assert_eq!(status, 0);
        stream.write_all(bytes).unwrap();
        assert_eq!(stream.read(&mut [0; 64]).unwrap_or(0), 0, "{bytes:?}");
    }
    for bytes in [&b"GET / HTTP/1.1\r\n\r\n"[..], &[1, 0x11, 0x80, 3, 0, 0, 0, 0, b'1'], &[0xFF; 8]] {
        let mut stream = sim.connect();
        stream.write_all(bytes).unwrap();
        let _ = stream.shutdown(std::net::Shutdown::Write);
        let _ = stream.read(&mut [0; 64]);
    }
    // a header cut short, a packet that is none, room for 4 GB, transfers without end that nobody serves
    let mut bus = sim.attach();
    bus.stream.write_all(&[0; 20]).unwrap();
    drop(bus);
    let mut bus = sim.attach();
    bus.bring(INTERRUPT.to_device, [0; 8], &[0xFF; 64]).unwrap();
    bus.bring(INTERRUPT.to_device, [0; 8], &[]).unwrap();
    let waiting: Vec<u32> = (0..1000).map(|_| bus.submit(BULK.to_host, u32::MAX, [0; 8], &[])).collect();
    let refused: Vec<_> = (64..1000).map(|_| bus.answer()).collect();
    assert!(refused.iter().all(|(seq, status, _)| *status < 0 && waiting[64..].contains(seq)));
    drop(bus);
    assert_eq!(sim.attach().open(), "SN42");
}
