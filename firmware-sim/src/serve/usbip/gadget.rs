//! The device's side of the bus: its endpoints, what waits at them, and the answers to control transfers. No socket, no time: a request in, answers
//! appended to bytes.
//!
//! A transfer that cannot be served yet is **parked**, as a device answers NAK until it can: towards the host until there is a packet, towards
//! the device until the firmware has taken what came before. Packets that no transfer fetches wait in a short queue; the newest push out the
//! oldest report, so that a host that comes late reads what is, not what was. Clearing a halt empties the queue: what is fetched next is new.

use std::collections::VecDeque;

use haptor_wire::usb::{BULK, Endpoints, INTERRUPT};
use haptor_wire::{FromDevice, PACKET_BYTES, decode_packet};

use super::descriptors::{CONFIGURATION, MS_SET_INDEX, MS_VENDOR_CODE, descriptor, ms_os_set};
use super::wire::{NO_ROOM, Request, STALLED, Submit, TAKEN_BACK, submitted, unlinked};

/// Packets that wait for the host: 8 ms of reports.
const FIFO: usize = 8;

/// Packets that an endpoint takes while the firmware has not looked: the two buffers of common chips.
const BUFFERS: usize = 2;

/// Transfers that may be parked at an endpoint; hosts keep a few.
const PARKED: usize = 64;

/// A transfer that waits.
#[derive(Debug)]
struct Parked {
    seq: u32,
    /// Room that the host has.
    room: usize,
    /// What it brings.
    data: Vec<u8>,
}

/// One pair of endpoints.
#[derive(Debug)]
struct Pair {
    at: Endpoints,
    halted_in: bool,
    halted_out: bool,
    fetching: VecDeque<Parked>,
    bringing: VecDeque<Parked>,
    to_host: VecDeque<Vec<u8>>,
    to_device: VecDeque<Vec<u8>>,
}

impl Pair {
    const fn new(at: Endpoints) -> Self {
        Self {
            at,
            halted_in: false,
            halted_out: false,
            fetching: VecDeque::new(),
            bringing: VecDeque::new(),
            to_host: VecDeque::new(),
            to_device: VecDeque::new(),
        }
    }

    /// Serves what waits, as far as it can be.
    fn serve(&mut self, out: &mut Vec<u8>) {
        while !self.to_host.is_empty() {
            let Some(parked) = self.fetching.pop_front() else { break };
            let packet = self.to_host.pop_front().unwrap_or_default();
            let carried = &packet[..packet.len().min(parked.room)];
            submitted(parked.seq, 0, carried.len(), carried, out);
        }
        while self.to_device.len() < BUFFERS {
            let Some(parked) = self.bringing.pop_front() else { break };
            submitted(parked.seq, 0, parked.data.len(), &[], out);
            self.to_device.push_back(parked.data);
        }
    }

    fn halt(&mut self, out: &mut Vec<u8>) {
        (self.halted_in, self.halted_out) = (true, true);
        for parked in self.fetching.drain(..).chain(self.bringing.drain(..)) {
            submitted(parked.seq, STALLED, 0, &[], out);
        }
    }

    fn halted(&mut self, address: u8) -> Option<&mut bool> {
        if address == self.at.to_host {
            Some(&mut self.halted_in)
        } else {
            (address == self.at.to_device).then_some(&mut self.halted_out)
        }
    }
}

/// The device on the bus.
#[derive(Debug)]
pub struct Gadget {
    serial: String,
    configuration: u8,
    pairs: [Pair; 2],
    /// The pair that was spoken on last.
    active: usize,
    /// Packets that the host did not fetch in time.
    overrun: u64,
}

impl Gadget {
    /// A device just plugged in.
    pub fn new(serial: &str) -> Self {
        Self {
            serial: serial.to_owned(),
            configuration: 0,
            pairs: [Pair::new(INTERRUPT), Pair::new(BULK)],
            active: 0,
            overrun: 0,
        }
    }

    /// Packets that the host did not fetch in time, since the start.
    pub const fn overrun(&self) -> u64 {
        self.overrun
    }

    /// Plugged in anew: nothing waits, nothing is halted.
    pub fn plugged_in(&mut self) {
        let overrun = self.overrun;
        *self = Self { overrun, ..Self::new(&self.serial) };
    }

    /// Takes a request with its data; appends what can be answered at once.
    pub fn request(&mut self, request: &Request, data: &[u8], out: &mut Vec<u8>) {
        match request {
            Request::Unlink { seq, victim } => {
                let status = if self.take_back(*victim) { TAKEN_BACK } else { 0 };
                unlinked(*seq, status, out);
            }
            Request::Submit(submit) if submit.endpoint == 0 => self.control(submit, out),
            Request::Submit(submit) => self.transfer(submit, data, out),
        }
    }

    /// The firmware sends a packet.
    pub fn send(&mut self, packet: &[u8], out: &mut Vec<u8>) {
        let pair = &mut self.pairs[self.active];
        if pair.to_host.len() >= FIFO {
            // who it is and what went wrong is said once, where it is comes again
            let oldest = pair.to_host.iter().position(|packet| is_report(packet)).unwrap_or(0);
            pair.to_host.remove(oldest);
            self.overrun += 1;
        }
        pair.to_host.push_back(packet.to_vec());
        if !pair.halted_in {
            pair.serve(out);
        }
    }

    /// The firmware takes the next packet.
    pub fn receive(&mut self, out: &mut Vec<u8>) -> Option<Vec<u8>> {
        let pair = self.pairs.iter_mut().find(|pair| !pair.to_device.is_empty())?;
        let packet = pair.to_device.pop_front();
        pair.serve(out);
        packet
    }

    /// Every endpoint halts until the host clears it.
    pub fn halt(&mut self, out: &mut Vec<u8>) {
        self.pairs.iter_mut().for_each(|pair| pair.halt(out));
    }

    fn take_back(&mut self, victim: u32) -> bool {
        for queue in self.pairs.iter_mut().flat_map(|pair| [&mut pair.fetching, &mut pair.bringing]) {
            if let Some(at) = queue.iter().position(|parked| parked.seq == victim) {
                queue.remove(at);
                return true;
            }
        }
        false
    }

    fn transfer(&mut self, submit: &Submit, data: &[u8], out: &mut Vec<u8>) {
        let address = submit.endpoint | if submit.to_host { 0x80 } else { 0 };
        let found = self.pairs.iter().position(|pair| [pair.at.to_device, pair.at.to_host].contains(&address));
        let Some(index) = found else { return submitted(submit.seq, STALLED, 0, &[], out) };
        if !submit.to_host {
            self.active = index;
        }
        let pair = &mut self.pairs[index];
        if pair.halted(address).is_none_or(|halted| *halted) {
            return submitted(submit.seq, STALLED, 0, &[], out);
        }
        let queue = if submit.to_host { &mut pair.fetching } else { &mut pair.bringing };
        if queue.len() >= PARKED {
            return submitted(submit.seq, NO_ROOM, 0, &[], out);
        }
        let parked = Parked { seq: submit.seq, room: submit.length.min(PACKET_BYTES), data: data.to_vec() };
        queue.push_back(parked);
        pair.serve(out);
    }

    fn control(&mut self, submit: &Submit, out: &mut Vec<u8>) {
        let answer = self.answer(submit.setup);
        match answer {
            Some(bytes) if submit.to_host => {
                let carried = &bytes[..bytes.len().min(submit.length)];
                submitted(submit.seq, 0, carried.len(), carried, out);
            }
            Some(_) => submitted(submit.seq, 0, submit.length, &[], out),
            None => submitted(submit.seq, STALLED, 0, &[], out),
        }
    }

    /// What a control transfer yields (USB 2.0, 9.4); `None` = stall.
    fn answer(&mut self, setup: [u8; 8]) -> Option<Vec<u8>> {
        let [kind, request, value_low, value_high, index_low, index_high, ..] = setup;
        let index = u16::from_le_bytes([index_low, index_high]);
        match (kind, request) {
            // GET_DESCRIPTOR
            (0x80, 6) => descriptor(value_high, value_low, &self.serial),
            // the OS 2.0 descriptors
            (0xC0, MS_VENDOR_CODE) if index == MS_SET_INDEX => Some(ms_os_set()),
            // GET_STATUS: self-powered; of an endpoint: halted
            (0x80, 0) => Some(vec![1, 0]),
            (0x81, 0) => Some(vec![0, 0]),
            (0x82, 0) => self.halted(index_low).map(|halted| vec![u8::from(*halted), 0]),
            // GET_CONFIGURATION, SET_CONFIGURATION
            (0x80, 8) => Some(vec![self.configuration]),
            (0x00, 9) if value_low <= CONFIGURATION => {
                self.configuration = value_low;
                self.clear_halts();
                Some(Vec::new())
            }
            // GET_INTERFACE, SET_INTERFACE: there is one
            (0x81, 10) => Some(vec![0]),
            (0x01, 11) if value_low == 0 && index == 0 => {
                self.clear_halts();
                Some(Vec::new())
            }
            // CLEAR_FEATURE, SET_FEATURE of an endpoint: halt
            (0x02, 1 | 3) if value_low == 0 => {
                *self.halted(index_low)? = request == 3;
                self.pairs.iter_mut().filter(|pair| pair.at.to_host == index_low).for_each(|pair| pair.to_host.clear());
                Some(Vec::new())
            }
            _ => None,
        }
    }

    /// Whether an endpoint is halted; `None` = there is no such one.
    fn halted(&mut self, address: u8) -> Option<&mut bool> {
        self.pairs.iter_mut().find_map(|pair| pair.halted(address))
    }

    fn clear_halts(&mut self) {
        self.pairs.iter_mut().for_each(|pair| (pair.halted_in, pair.halted_out) = (false, false));
    }
}

/// Whether a packet says where the handle is; anything else counts as said once.
fn is_report(packet: &[u8]) -> bool {
    matches!(decode_packet(packet), Ok(FromDevice::Pose(_)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::serve::drill::Noise;
    use crate::serve::usbip::wire::{self, HEADER_BYTES};
    use haptor_wire::{DeviceFault, FaultCause, Mode, PoseReport, encode_packet};

    fn submit(seq: u32, to_host: bool, endpoint: u8, length: usize) -> Request {
        Request::Submit(Submit { seq, to_host, endpoint, length, setup: [0; 8] })
    }

    /// The answers in `out`: number, status, data of those that carry any to the host.
    fn answers(out: &[u8], to_host: &[u32]) -> Vec<(u32, i32, Vec<u8>)> {
        let (mut rest, mut all) = (out, Vec::new());
        while let Some((header, after)) = rest.split_at_checked(HEADER_BYTES) {
            let word = |at: usize| u32::from_be_bytes(header[4 * at..4 * at + 4].try_into().unwrap());
            let data = if to_host.contains(&word(1)) { word(6) as usize } else { 0 };
            all.push((word(1), word(5) as i32, after[..data].to_vec()));
            rest = &after[data..];
        }
        assert!(rest.is_empty());
        all
    }

    #[test]
    fn a_transfer_waits_for_its_packet_and_a_packet_for_its_transfer() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        gadget.request(&submit(1, true, 1, 64), &[], &mut out);
        assert!(out.is_empty(), "parked");
        gadget.send(&[7; 64], &mut out);
        gadget.send(&[8; 64], &mut out);
        gadget.request(&submit(2, true, 1, 4), &[], &mut out);
        assert_eq!(answers(&out, &[1, 2]), [(1, 0, vec![7; 64]), (2, 0, vec![8; 4])]);
    }

    #[test]
    fn the_newest_packets_are_kept() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        (0..20).for_each(|n| gadget.send(&[n], &mut out));
        gadget.request(&submit(1, true, 1, 64), &[], &mut out);
        assert_eq!((answers(&out, &[1]), gadget.overrun()), (vec![(1, 0, vec![12])], 12));
    }

    #[test]
    fn reports_push_out_reports_and_not_what_is_said_once() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        let pose = PoseReport {
            seq: 5,
            t_us: 0,
            position_nm: [0; 3],
            rotation_q30: [0; 4],
            buttons: 0,
            mode: Mode::Idle,
            flags: 0,
            echo: 0,
        };
        let pose = |seq| encode_packet(&FromDevice::Pose(PoseReport { seq, ..pose })).unwrap();
        let fault = encode_packet(&FromDevice::Fault(DeviceFault { cause: FaultCause::Hardware, seq: 0, detail: 0 })).unwrap();
        gadget.send(&pose(0), &mut out);
        gadget.send(&fault, &mut out);
        (1..30).for_each(|seq| gadget.send(&pose(seq), &mut out));
        (1..=2).for_each(|seq| gadget.request(&submit(seq, true, 1, 64), &[], &mut out));
        assert_eq!(answers(&out, &[1, 2]), [(1, 0, fault.to_vec()), (2, 0, pose(23).to_vec())]);
    }

    #[test]
    fn a_transfer_taken_back_is_not_answered_and_one_that_was_cannot_be_taken_back() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        gadget.request(&submit(1, true, 1, 64), &[], &mut out);
        gadget.request(&submit(2, true, 1, 64), &[], &mut out);
        for (seq, victim) in [(3, 1), (4, 1), (5, 999)] {
            gadget.request(&Request::Unlink { seq, victim }, &[], &mut out);
        }
        gadget.send(&[9], &mut out);
        assert_eq!(answers(&out, &[2]), [(3, TAKEN_BACK, vec![]), (4, 0, vec![]), (5, 0, vec![]), (2, 0, vec![9])]);
    }

    #[test]
    fn a_firmware_that_does_not_look_holds_up_the_third_packet() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        for seq in 1..=3 {
            gadget.request(&submit(seq, false, 1, 1), &[seq as u8], &mut out);
        }
        assert_eq!(answers(&out, &[]).len(), BUFFERS);
        assert_eq!(gadget.receive(&mut out), Some(vec![1]));
        assert_eq!(answers(&out, &[]).len(), 3);
        assert_eq!(
            (gadget.receive(&mut out), gadget.receive(&mut out), gadget.receive(&mut out)),
            (Some(vec![2]), Some(vec![3]), None)
        );
    }

    #[test]
    fn it_answers_on_the_pair_that_spoke_last() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        gadget.request(&submit(1, false, 2, 1), &[1], &mut out);
        gadget.send(&[5], &mut out);
        gadget.request(&submit(2, true, 1, 64), &[], &mut out);
        gadget.request(&submit(3, true, 2, 64), &[], &mut out);
        assert_eq!(answers(&out, &[2, 3]), [(1, 0, vec![]), (3, 0, vec![5])]);
    }

    #[test]
    fn a_halted_endpoint_stalls_until_it_is_cleared() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        gadget.request(&submit(1, true, 1, 64), &[], &mut out);
        gadget.halt(&mut out);
        gadget.send(&[1], &mut out);
        gadget.request(&submit(2, true, 1, 64), &[], &mut out);
        let clear = Submit { seq: 3, to_host: false, endpoint: 0, length: 0, setup: [2, 1, 0, 0, 0x81, 0, 0, 0] };
        gadget.request(&Request::Submit(clear), &[], &mut out);
        gadget.request(&submit(4, true, 1, 64), &[], &mut out);
        gadget.send(&[2], &mut out);
        gadget.request(&submit(5, false, 1, 1), &[0], &mut out);
        let expected = [(1, STALLED, vec![]), (2, STALLED, vec![]), (3, 0, vec![]), (4, 0, vec![2]), (5, STALLED, vec![])];
        assert_eq!(answers(&out, &[1, 2, 4]), expected);
    }

    #[test]
    fn parked_transfers_are_bounded_and_unknown_endpoints_stall() {
        let (mut gadget, mut out) = (Gadget::new("T"), Vec::new());
        for seq in 0..PARKED as u32 + 1 {
            gadget.request(&submit(seq, true, 1, usize::MAX), &[], &mut out);
        }
        gadget.request(&submit(1000, true, 9, 64), &[], &mut out);
        assert_eq!(answers(&out, &[]), [(PARKED as u32, NO_ROOM, vec![]), (1000, STALLED, vec![])]);
    }

    /// Requests of random numbers, most of them in the neighbourhood of good ones.
    #[test]
    fn whatever_is_asked_is_answered_and_nothing_grows_without_bound() {
        let (mut gadget, mut out, mut noise) = (Gadget::new("T"), Vec::new(), Noise::new(7));
        let mut asked = 0;
        for _ in 0..200_000 {
            let mut words: [u32; 12] = std::array::from_fn(|_| (noise.next() >> 40) as u32);
            let kinds = [3, 400, 1, 2, 4, 1, 256, 1, 1, 1];
            for (word, kind) in words.iter_mut().zip(kinds) {
                *word %= if noise.next() % 50 == 0 { u32::MAX } else { kind };
            }
            (words[10], words[11]) = (words[10] & 0xFF0F_0F0F | 0x8000_0000, words[11] & 0x8100_FFFF);
            let header: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
            let Some(request) = wire::request(header.first_chunk().unwrap()) else { continue };
            let length = if let Request::Submit(submit) = &request { submit.data_bytes() } else { 0 };
            gadget.request(&request, &[0xAA; wire::TRANSFER_BYTES][..length], &mut out);
            match noise.next() % 64 {
                0 => gadget.send(&[1; 64], &mut out),
                1 => drop(gadget.receive(&mut out)),
                2 => gadget.halt(&mut out),
                _ => {}
            }
            assert!(out.len() <= 4 * PARKED * (HEADER_BYTES + PACKET_BYTES) + wire::TRANSFER_BYTES);
            out.clear();
            asked += 1;
        }
        assert!(asked > 100_000, "{asked} requests were of the protocol");
        for pair in &gadget.pairs {
            assert!(pair.fetching.len() <= PARKED && pair.bringing.len() <= PARKED);
            assert!(pair.to_host.len() <= FIFO && pair.to_device.len() <= BUFFERS);
        }
    }
}
