//! The scenes on a PC, under an operating system's C library and nothing else.

use crate::bench::{self, Count, Room};
use crate::cases;

/// Makes calls.
struct Calls;

impl Count for Calls {
    fn count(&mut self, call: impl FnOnce()) {
        call();
    }
}

/// Where the C library begins; 0 when every scene had the regions that it must have.
// SAFETY: the name is the C library's for this function and no other of this image has it
#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    let mut room = Room::new();
    let good = cases::all().all(|case| {
        room.clear();
        bench::run(&case, &mut room, &mut Calls) == Ok(case.regions)
    });
    i32::from(!good)
}
