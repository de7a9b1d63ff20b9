//! The device on a USB cable that is a socket: USB/IP, as the kernel's `vhci-hcd` speaks it.
//!
//! ```text
//!  kernel ◄── socket ──► carry: a thread that answers as the bus would ──► Gadget ◄── the loop: packets once a millisecond
//! ```
//! Transfers are answered by a thread of their own, as a chip's USB part does; the loop, which is the firmware, only puts packets in and takes
//! packets out. Attached over TCP by the stock `usbip attach`, or straight to this machine's kernel ([`vhci`]).
//!
//! Written by hand because a device must be able to answer later, not at all, or wrongly; what the protocol needs of it is [`wire`].

mod descriptors;
mod gadget;
mod vhci;
mod wire;

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};
use haptor_wire::{ToDevice, decode_packet, encode_stream};

use gadget::Gadget;
use wire::{BUS_ID, BUS_ID_BYTES, HEADER_BYTES, OP_BYTES, Opening, Refusal, Request, TRANSFER_BYTES, padded};

/// How long a client may take to say what it wants, and to take an answer; a kernel takes microseconds.
const PATIENCE: Duration = Duration::from_secs(1);

/// Room that a message needs in a stream.
const FRAME_BYTES: usize = haptor_wire::stream_bound(ToDevice::MAX_ENCODED);

/// Where to be attached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Over TCP, by `usbip attach`.
    Tcp(SocketAddr),
    /// To this machine's own kernel.
    Vhci,
}

/// The device's USB port.
#[derive(Debug)]
pub struct Usb {
    bus: Arc<Bus>,
    way: Way,
    place: String,
    bad_packets: u64,
}

/// What the loop and the thread that carries share.
#[derive(Debug)]
struct Bus(Mutex<State>);

#[derive(Debug)]
struct State {
    gadget: Gadget,
    plugged: bool,
    socket: Option<UnixStream>,
    /// Times it was attached; tells a thread whether the socket is still its own.
    attached: u64,
    /// Attached since the loop last looked.
    anew: bool,
}

impl Usb {
    /// Listens, or plugs in.
    pub fn open(way: Way, serial: &str) -> Result<Self> {
        let state = State { gadget: Gadget::new(serial), plugged: true, socket: None, attached: 0, anew: false };
        let bus = Arc::new(Bus(Mutex::new(state)));
        let place = match way {
            Way::Tcp(address) => {
                let listener = TcpListener::bind(address).with_context(|| format!("cannot listen at {address}"))?;
                let place = format!("usbip {}", listener.local_addr()?);
                let bus = Arc::clone(&bus);
                thread::Builder::new().name("usbip".into()).spawn(move || admit(&listener, &bus))?;
                place
            }
            Way::Vhci => {
                let (port, socket) = vhci::attach()?;
                bus.attach(socket)?;
                format!("vhci port {port}")
            }
        };
        Ok(Self { bus, way, place, bad_packets: 0 })
    }

    /// Where it is attached.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// Packets that nobody fetched, and packets that were no messages.
    pub fn lost(&self) -> (u64, u64) {
        (self.bus.state().gadget.overrun(), self.bad_packets)
    }

    /// Whether it was attached since last asked.
    pub fn newly_attached(&mut self) -> bool {
        std::mem::take(&mut self.bus.state().anew)
    }

    /// What has come, as the same messages in a stream.
    pub fn read(&mut self, buffer: &mut [u8]) -> usize {
        let mut used = 0;
        while buffer.len() - used >= FRAME_BYTES {
            let Some(packet) = self.bus.receive() else { break };
            let message = decode_packet::<ToDevice>(&packet);
            match message.and_then(|message| encode_stream(&message, &mut buffer[used..])) {
                Ok(n) => used += n,
                Err(_) => self.bad_packets += 1,
            }
        }
        used
    }

    /// Sends a packet.
    pub fn write(&mut self, packet: &[u8]) {
        self.bus.act(|gadget, out| gadget.send(packet, out));
    }

    /// Every endpoint halts until the host clears it.
    pub fn halt(&mut self) {
        self.bus.act(Gadget::halt);
    }

    /// Pulls the cable.
    pub fn unplug(&mut self) {
        let mut state = self.bus.state();
        state.plugged = false;
        state.hang_up();
    }

    /// Plugs it in again.
    pub fn plug_in(&mut self) -> Result<()> {
        self.bus.state().plugged = true;
        if self.way == Way::Vhci {
            let (_, socket) = vhci::attach()?;
            self.bus.attach(socket)?;
        }
        Ok(())
    }
}

impl State {
    fn hang_up(&mut self) {
        if let Some(socket) = self.socket.take() {
            let _ = socket.shutdown(Shutdown::Both);
        }
    }

    /// Sends answers; a peer that does not take them is gone.
    fn answer(&mut self, out: &[u8]) {
        let Some(socket) = &mut self.socket else { return };
        if !out.is_empty() && socket.write_all(out).is_err() {
            self.hang_up();
        }
    }
}

impl Bus {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does something to the device and sends the answers that follow from it.
    fn act<T>(&self, what: impl FnOnce(&mut Gadget, &mut Vec<u8>) -> T) -> T {
        let (mut state, mut out) = (self.state(), Vec::new());
        let done = what(&mut state.gadget, &mut out);
        state.answer(&out);
        done
    }

    fn receive(&self) -> Option<Vec<u8>> {
        self.act(Gadget::receive)
    }

    /// Takes a socket and has it carried.
    fn attach(self: &Arc<Self>, socket: UnixStream) -> Result<()> {
        socket.set_read_timeout(None)?;
        socket.set_write_timeout(Some(PATIENCE))?;
        let mut state = self.state();
        state.hang_up();
        state.gadget.plugged_in();
        state.socket = Some(socket.try_clone()?);
        state.attached += 1;
        state.anew = true;
        let (bus, mine) = (Arc::clone(self), state.attached);
        thread::Builder::new().name("usb".into()).spawn(move || carry(&bus, socket, mine))?;
        Ok(())
    }
}

/// Answers transfers until the other end goes or says what is no USB/IP.
fn carry(bus: &Bus, mut socket: UnixStream, mine: u64) {
    let mut data = [0; TRANSFER_BYTES];
    while let Some((request, length)) = read_request(&mut socket, &mut data) {
        bus.act(|gadget, out| gadget.request(&request, &data[..length], out));
    }
    let mut state = bus.state();
    if state.attached == mine {
        state.hang_up();
    }
}

fn read_request(socket: &mut impl Read, data: &mut [u8]) -> Option<(Request, usize)> {
    let mut header = [0; HEADER_BYTES];
    socket.read_exact(&mut header).ok()?;
    let request = wire::request(&header)?;
    let length = match &request {
        Request::Submit(submit) => submit.data_bytes(),
        Request::Unlink { .. } => 0,
    };
    socket.read_exact(data.get_mut(..length)?).ok()?;
    Some((request, length))
}

/// Takes clients one after the other. What one did wrong is its own affair.
fn admit(listener: &TcpListener, bus: &Arc<Bus>) {
    for stream in listener.incoming().flatten() {
        let _ = greet(stream, bus);
    }
}

fn greet(mut stream: TcpStream, bus: &Arc<Bus>) -> Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut asked = [0; OP_BYTES];
    stream.read_exact(&mut asked)?;
    match wire::opening(&asked).ok_or(io::ErrorKind::InvalidData).map_err(io::Error::from)? {
        Opening::List => stream.write_all(&wire::list())?,
        Opening::Import => {
            let mut name = [0; BUS_ID_BYTES];
            stream.read_exact(&mut name)?;
            let refused = refusal(&name, &bus.state());
            stream.write_all(&wire::imported(refused))?;
            if refused.is_none() {
                // a socket is a socket: from here on it is treated as the kernel's own pair is
                bus.attach(UnixStream::from(OwnedFd::from(stream)))?;
            }
        }
    }
    Ok(())
}

fn refusal(name: &[u8; BUS_ID_BYTES], state: &State) -> Option<Refusal> {
    if *name != padded(BUS_ID) {
        Some(Refusal::NoSuchDevice)
    } else if !state.plugged {
        Some(Refusal::NotAvailable)
    } else {
        state.socket.is_some().then_some(Refusal::Busy)
    }
}
