//! What the device says it is: descriptors of USB 2.1 (USB 2.0, chapter 9), and Microsoft's OS 2.0 descriptors, by which Windows binds WinUSB
//! without a driver of ours.

use haptor_wire::PACKET_BYTES;
use haptor_wire::usb::{BULK, INTERFACE, INTERFACE_TRIPLE, INTERRUPT, INTERRUPT_INTERVAL, PRODUCT_ID, VENDOR_ID};

/// 2.1: the first version whose hosts ask for the BOS, in which the OS 2.0 descriptors are announced.
const BCD_USB: u16 = 0x0210;

/// Version of the device.
pub const BCD_DEVICE: u16 = 0x0100;

/// Largest packet of a bulk endpoint; high speed knows no other.
const BULK_BYTES: u16 = 512;

/// Largest packet of the control endpoint.
const CONTROL_BYTES: u8 = 64;

/// The one configuration.
pub const CONFIGURATION: u8 = 1;

/// Request by which Windows asks for the OS 2.0 descriptors; the BOS tells it.
pub const MS_VENDOR_CODE: u8 = 0x20;

/// Its `wIndex`: the descriptor set.
pub const MS_SET_INDEX: u16 = 7;

/// The device interface's name on Windows: what a program there looks for.
const INTERFACE_GUID: &str = "{6C1D9A52-5B0E-4E1C-9B6B-0C8C7C0A48F1}";

/// Windows 8.1, the first that knows these descriptors.
const WINDOWS_8_1: u32 = 0x0603_0000;

/// D8DD60DF-4589-4CC7-9CD2-659D9E648A9F, the platform capability of OS 2.0 descriptors, as it lies in memory.
const MS_PLATFORM: [u8; 16] = [0xDF, 0x60, 0xDD, 0xD8, 0x89, 0x45, 0xC7, 0x4C, 0x9C, 0xD2, 0x65, 0x9D, 0x9E, 0x64, 0x8A, 0x9F];

/// Kinds of descriptor.
const DEVICE: u8 = 1;
const CONFIG: u8 = 2;
const STRING: u8 = 3;
const INTERFACE_KIND: u8 = 4;
const ENDPOINT: u8 = 5;
const BOS: u8 = 15;
const CAPABILITY: u8 = 16;

/// Transfer types of an endpoint.
const IS_BULK: u8 = 2;
const IS_INTERRUPT: u8 = 3;

/// The descriptor of a kind and number; `None` = there is none, which the device answers by a stall.
pub fn descriptor(kind: u8, index: u8, serial: &str) -> Option<Vec<u8>> {
    match (kind, index) {
        (DEVICE, 0) => Some(device()),
        (CONFIG, 0) => Some(configuration()),
        (STRING, 0) => Some(vec![4, STRING, 0x09, 0x04]),
        (STRING, index) => string(index, serial),
        (BOS, 0) => Some(bos()),
        _ => None,
    }
}

fn device() -> Vec<u8> {
    let mut bytes = vec![18, DEVICE];
    bytes.extend(BCD_USB.to_le_bytes());
    bytes.extend([0, 0, 0, CONTROL_BYTES]);
    for number in [VENDOR_ID, PRODUCT_ID, BCD_DEVICE] {
        bytes.extend(number.to_le_bytes());
    }
    // strings of maker, product, serial number; configurations
    bytes.extend([1, 2, 3, 1]);
    bytes
}

fn configuration() -> Vec<u8> {
    let (class, subclass, protocol) = INTERFACE_TRIPLE;
    let mut body = vec![9, INTERFACE_KIND, INTERFACE, 0, 4, class, subclass, protocol, 4];
    for (pair, kind, length, interval) in
        [(INTERRUPT, IS_INTERRUPT, PACKET_BYTES as u16, INTERRUPT_INTERVAL), (BULK, IS_BULK, BULK_BYTES, 0)]
    {
        for address in [pair.to_device, pair.to_host] {
            let [low, high] = length.to_le_bytes();
            body.extend([7, ENDPOINT, address, kind, low, high, interval]);
        }
    }
    let [low, high] = (9 + body.len() as u16).to_le_bytes();
    // self-powered, 100 mA of the bus
    let mut bytes = vec![9, CONFIG, low, high, 1, CONFIGURATION, 0, 0xC0, 50];
    bytes.append(&mut body);
    bytes
}

fn string(index: u8, serial: &str) -> Option<Vec<u8>> {
    let text = match index {
        1 => "haptor",
        2 => "simulated haptic device",
        3 => serial,
        4 => "haptor device link",
        _ => return None,
    };
    let units = utf16(text);
    let mut bytes = vec![2 + units.len() as u8, STRING];
    bytes.extend(units);
    Some(bytes)
}

fn utf16(text: &str) -> Vec<u8> {
    text.encode_utf16().flat_map(u16::to_le_bytes).collect()
}

fn bos() -> Vec<u8> {
    let mut bytes = vec![5, BOS, 33, 0, 1, 28, CAPABILITY, 5, 0];
    bytes.extend(MS_PLATFORM);
    bytes.extend(WINDOWS_8_1.to_le_bytes());
    bytes.extend((ms_os_set().len() as u16).to_le_bytes());
    bytes.extend([MS_VENDOR_CODE, 0]);
    bytes
}

/// The OS 2.0 descriptor set: header, compatible id WINUSB, the interface's name in the registry.
pub fn ms_os_set() -> Vec<u8> {
    let mut compatible = vec![20, 0, 3, 0];
    compatible.extend(b"WINUSB\0\0\0\0\0\0\0\0\0\0");
    let name = utf16("DeviceInterfaceGUIDs\0");
    let value = utf16(&format!("{INTERFACE_GUID}\0\0"));
    let mut property = Vec::new();
    // kind 4 = registry property, type 7 = REG_MULTI_SZ
    for number in [(10 + name.len() + value.len()) as u16, 4, 7, name.len() as u16] {
        property.extend(number.to_le_bytes());
    }
    property.extend(name);
    property.extend((value.len() as u16).to_le_bytes());
    property.extend(value);
    let total = 10 + compatible.len() + property.len();
    let mut bytes = vec![10, 0, 0, 0];
    bytes.extend(WINDOWS_8_1.to_le_bytes());
    bytes.extend((total as u16).to_le_bytes());
    bytes.extend(compatible);
    bytes.extend(property);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_descriptor_tells_its_own_length() {
        for (kind, index, length) in [(DEVICE, 0, 18), (STRING, 0, 4), (STRING, 2, 48)] {
            let bytes = descriptor(kind, index, "SIM-1").unwrap();
            assert_eq!((bytes.len(), usize::from(bytes[0]), bytes[1]), (length, length, kind));
        }
        for (kind, length) in [(CONFIG, 9 + 9 + 4 * 7), (BOS, 33)] {
            let bytes = descriptor(kind, 0, "SIM-1").unwrap();
            assert_eq!((bytes.len(), usize::from(u16::from_le_bytes([bytes[2], bytes[3]]))), (length, length));
        }
        let set = ms_os_set();
        assert_eq!((set.len(), u16::from_le_bytes([set[8], set[9]])), (162, 162));
        for (kind, index) in [(DEVICE, 1), (CONFIG, 1), (STRING, 5), (6, 0), (0, 0)] {
            assert_eq!(descriptor(kind, index, "SIM-1"), None, "{kind} {index}");
        }
    }

    #[test]
    fn parts_of_a_configuration_follow_one_another() {
        let bytes = configuration();
        let mut kinds = Vec::new();
        let mut at = 0;
        while at < bytes.len() {
            kinds.push(bytes[at + 1]);
            at += usize::from(bytes[at]);
        }
        assert_eq!((at, kinds), (bytes.len(), vec![CONFIG, INTERFACE_KIND, ENDPOINT, ENDPOINT, ENDPOINT, ENDPOINT]));
    }
}
