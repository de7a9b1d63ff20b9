//! Bits, faults and vectors of the wire as a window shows them.

use haptor_contact::Flags;
use haptor_viewer::feed::Fault;
use haptor_viewer::{DQuat, DVec3};
use haptor_wire::{HostFault, flags};

/// First bit of the host's flags.
const HOST_BITS: u32 = 24;

/// The names of the bits that are set.
pub fn flag_words(bits: u32) -> Vec<String> {
    let core = Flags::NAMES.iter().enumerate().map(|(bit, name)| (bit as u32, *name));
    let host = flags::NAMES.iter().enumerate().map(|(bit, name)| (HOST_BITS + bit as u32, *name));
    core.chain(host).filter(|(bit, _)| bits >> bit & 1 == 1).map(|(_, name)| name.to_owned()).collect()
}

/// A fault with what to do about it.
pub fn fault(fault: HostFault) -> Fault {
    Fault { what: fault.name().to_owned(), advice: advice(fault).to_owned() }
}

const fn advice(fault: HostFault) -> &'static str {
    match fault {
        HostFault::LinkLost => "plug the device in again; forces return from a small one",
        HostFault::Stale => "the device sends no poses: look at its cable and at the load of the machine",
        HostFault::Garbage => "wrong port or speed, or another program reads along",
        HostFault::DeviceRestarted => "the device began anew: look at its supply",
        HostFault::DeviceFault => "the device reports a fault of its own",
        HostFault::DeviceWatchdog => "the host was too slow for the device: `haptor doctor`",
        HostFault::DeviceOverSpeed => "the handle moved too fast: hold it, then come out of the object",
        HostFault::DeviceNonFinite | HostFault::NonFinite => "the black box holds the ticks before it",
        HostFault::VersionMismatch => "bring host and device to one version",
        HostFault::Overrun => "this machine is too slow for the rate: `haptor doctor`",
    }
}

/// f32 to f64.
pub fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// A rotation of the wire, (w, x, y, z).
pub fn rotation([w, x, y, z]: [f32; 4]) -> DQuat {
    DQuat::from_xyzw(x.into(), y.into(), z.into(), w.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_of_core_and_host_have_names() {
        assert_eq!(flag_words(0), Vec::<String>::new());
        assert_eq!(flag_words(Flags::FORCE_LIMITED.0 | flags::LATE), ["force limited", "late"]);
    }
}
