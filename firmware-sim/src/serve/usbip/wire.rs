//! USB/IP's bytes (Linux, Documentation/usb/usbip_protocol.rst): how a kernel and a device talk over a socket. All numbers big-endian.
//!
//! First, over TCP, a client lists devices or imports one; then, in both directions on the same socket, transfers: a **submit** asks for
//! one, its answer carries status and data, an **unlink** takes one back. A header has 48 bytes, data follow.

use haptor_wire::usb::{INTERFACE_TRIPLE, PRODUCT_ID, VENDOR_ID};

use super::descriptors::{BCD_DEVICE, CONFIGURATION};

/// Version of the protocol.
const VERSION: u16 = 0x0111;

/// What a client asks for first.
const LIST: u16 = 0x8005;
const IMPORT: u16 = 0x8003;

/// Bytes of such a request before the name of a device.
pub const OP_BYTES: usize = 8;

/// Bytes of the name.
pub const BUS_ID_BYTES: usize = 32;

/// Name of the only device.
pub const BUS_ID: &str = "1-1";

/// Its number, bus and device in one.
pub const DEVICE_ID: u32 = 1 << 16 | 2;

/// High speed, as both the protocol and vhci count.
pub const HIGH_SPEED: u32 = 3;

/// Bytes of a transfer's header.
pub const HEADER_BYTES: usize = 48;

/// Bytes that a transfer may carry: the largest control transfer of any descriptor, with room. Nobody who has read the descriptors sends more.
pub const TRANSFER_BYTES: usize = 4096;

const SUBMIT: u32 = 1;
const UNLINK: u32 = 2;
const SUBMITTED: u32 = 3;
const UNLINKED: u32 = 4;

/// Statuses of a transfer: Linux's error numbers.
pub const STALLED: i32 = -32;
pub const TAKEN_BACK: i32 = -104;
pub const NO_ROOM: i32 = -12;

/// What a client asks for first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// Which devices there are.
    List,
    /// The device whose name follows in [`BUS_ID_BYTES`] bytes.
    Import,
}

/// Why an import is refused, as the stock client names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Unplugged.
    NotAvailable = 1,
    /// Another client has it.
    Busy = 2,
    /// No device of that name.
    NoSuchDevice = 4,
}

/// Reads what a client asks for first; `None` = not this protocol.
pub fn opening(bytes: &[u8; OP_BYTES]) -> Option<Opening> {
    let [v1, v0, c1, c0, ..] = *bytes;
    match (u16::from_be_bytes([v1, v0]), u16::from_be_bytes([c1, c0])) {
        (VERSION, LIST) => Some(Opening::List),
        (VERSION, IMPORT) => Some(Opening::Import),
        _ => None,
    }
}

/// The answer to [`Opening::List`].
pub fn list() -> Vec<u8> {
    let mut bytes = op_header(LIST, 0);
    bytes.extend(1_u32.to_be_bytes());
    bytes.extend(device());
    let (class, subclass, protocol) = INTERFACE_TRIPLE;
    bytes.extend([class, subclass, protocol, 0]);
    bytes
}

/// The answer to [`Opening::Import`].
pub fn imported(refused: Option<Refusal>) -> Vec<u8> {
    match refused {
        Some(why) => op_header(IMPORT, why as u32),
        None => [op_header(IMPORT, 0), device()].concat(),
    }
}

fn op_header(code: u16, status: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(VERSION.to_be_bytes());
    bytes.extend((code & 0x7FFF).to_be_bytes());
    bytes.extend(status.to_be_bytes());
    bytes
}

fn device() -> Vec<u8> {
    let mut bytes = padded::<256>("/sys/devices/haptor/usb1/1-1").to_vec();
    bytes.extend(padded::<BUS_ID_BYTES>(BUS_ID));
    for number in [DEVICE_ID >> 16, DEVICE_ID & 0xFFFF, HIGH_SPEED] {
        bytes.extend(number.to_be_bytes());
    }
    for number in [VENDOR_ID, PRODUCT_ID, BCD_DEVICE] {
        bytes.extend(number.to_be_bytes());
    }
    // class, subclass, protocol of the device; configuration, configurations, interfaces
    bytes.extend([0, 0, 0, CONFIGURATION, 1, 1]);
    bytes
}

/// A text in a field of fixed length.
pub fn padded<const N: usize>(text: &str) -> [u8; N] {
    let mut field = [0; N];
    field.iter_mut().zip(text.bytes()).for_each(|(to, byte)| *to = byte);
    field
}

/// What a kernel asks of an imported device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// A transfer.
    Submit(Submit),
    /// Takes a transfer back.
    Unlink {
        /// Number of this request.
        seq: u32,
        /// Number of the transfer.
        victim: u32,
    },
}

/// A transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Submit {
    /// Its number.
    pub seq: u32,
    /// Towards the host.
    pub to_host: bool,
    /// Number of the endpoint, 0 = control.
    pub endpoint: u8,
    /// Bytes that it carries, or that the host has room for.
    pub length: usize,
    /// Of a control transfer.
    pub setup: [u8; 8],
}

impl Submit {
    /// Bytes that follow the header.
    pub const fn data_bytes(&self) -> usize {
        if self.to_host { 0 } else { self.length }
    }
}

/// Reads a header; `None` = not this protocol, too long, or isochronous, which this device has not.
pub fn request(header: &[u8; HEADER_BYTES]) -> Option<Request> {
    let word = |at: usize| header.get(4 * at..4 * at + 4)?.try_into().ok().map(u32::from_be_bytes);
    let (command, seq) = (word(0)?, word(1)?);
    match command {
        UNLINK => Some(Request::Unlink { seq, victim: word(5)? }),
        SUBMIT => {
            let (direction, endpoint, length, packets) = (word(3)?, word(4)?, word(6)? as usize, word(8)?);
            let to_host = direction == 1;
            // a host may have room for more than there ever is; what it sends must be bounded
            let too_long = !to_host && length > TRANSFER_BYTES;
            if direction > 1 || endpoint > 15 || too_long || !matches!(packets, 0 | u32::MAX) {
                return None;
            }
            let setup = header[40..].try_into().ok()?;
            Some(Request::Submit(Submit { seq, to_host, endpoint: endpoint as u8, length, setup }))
        }
        _ => None,
    }
}

/// Appends the answer to a transfer: `carried` bytes went through, `data` of them follow when they go to the host.
pub fn submitted(seq: u32, status: i32, carried: usize, data: &[u8], out: &mut Vec<u8>) {
    header(SUBMITTED, seq, status, carried as u32, out);
    out.extend_from_slice(data);
}

/// Appends the answer to an unlink.
pub fn unlinked(seq: u32, status: i32, out: &mut Vec<u8>) {
    header(UNLINKED, seq, status, 0, out);
}

fn header(command: u32, seq: u32, status: i32, carried: u32, out: &mut Vec<u8>) {
    let end = out.len() + HEADER_BYTES;
    for word in [command, seq, 0, 0, 0, status as u32, carried] {
        out.extend(word.to_be_bytes());
    }
    out.resize(end, 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header_of(words: [u32; 12]) -> [u8; HEADER_BYTES] {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
        bytes.try_into().unwrap()
    }

    #[test]
    fn transfers_read_as_the_kernel_writes_them() {
        let submit = header_of([1, 7, 0x10002, 1, 1, 0, 64, 0, 0, 4, 0x8006_0001, 0x0000_1200]);
        let expected = Submit { seq: 7, to_host: true, endpoint: 1, length: 64, setup: [0x80, 6, 0, 1, 0, 0, 0x12, 0] };
        assert_eq!(request(&submit), Some(Request::Submit(expected)));
        let unlink = header_of([2, 8, 0x10002, 0, 0, 7, 0, 0, 0, 0, 0, 0]);
        assert_eq!(request(&unlink), Some(Request::Unlink { seq: 8, victim: 7 }));
    }

    #[test]
    fn what_is_not_this_protocol_is_refused() {
        for words in [
            [0; 12],
            [5, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
            [u32::MAX; 12],
            [1, 1, 0, 2, 1, 0, 0, 0, 0, 0, 0, 0],
            [1, 1, 0, 0, 16, 0, 0, 0, 0, 0, 0, 0],
            [1, 1, 0, 0, 1, 0, TRANSFER_BYTES as u32 + 1, 0, 0, 0, 0, 0],
            [1, 1, 0, 1, 1, 0, 64, 0, 5, 0, 0, 0],
        ] {
            assert_eq!(request(&header_of(words)), None, "{words:?}");
        }
        assert_eq!(opening(&[1, 0x10, 0x80, 5, 0, 0, 0, 0]), None, "another version");
        assert_eq!(opening(b"GET / HT"), None);
    }

    #[test]
    fn answers_have_the_lengths_of_the_protocol() {
        assert_eq!((list().len(), imported(None).len(), imported(Some(Refusal::Busy)).len()), (8 + 4 + 312 + 4, 8 + 312, 8));
        let mut out = Vec::new();
        submitted(9, 0, 3, &[1, 2, 3], &mut out);
        assert_eq!(
            (out.len(), &out[..8], &out[20..28], &out[48..]),
            (51, &[0, 0, 0, 3, 0, 0, 0, 9][..], &[0, 0, 0, 0, 0, 0, 0, 3][..], &[1, 2, 3][..])
        );
        out.clear();
        unlinked(1, TAKEN_BACK, &mut out);
        assert_eq!((out.len(), &out[20..24]), (48, &(-104_i32).to_be_bytes()[..]));
    }
}
